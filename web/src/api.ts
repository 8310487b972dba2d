// The JSON API of the server, typed.

export interface Status {
  id: string;
  state: "queued" | "running" | "done" | "failed" | "cancelled";
  stage: string;
  progress: number;
  error: string | null;
  before: number;
}

export interface About {
  version: string;
  samples: string[];
  presets: string[];
  methods: string[];
  cues: string[];
  exports: string[];
  endings: Record<string, string[]>;
  limits: { upload_bytes: number; pixels: number; points: number; keep_seconds: number };
}

export interface Summary {
  k: number;
  preset: string;
  method: string;
  cues: string;
  weight: number | null;
  quality: number | null;
  weight_curve: [number, number][];
  timings_s: Record<string, number>;
  warnings: string[];
}

export interface View {
  n_regions: number;
  merges: [number, number][];
  heights: number[];
  start: number;
  shape: number[];
  depth: [number, number] | null;
  points: number;
  size: number[];
  color: [number, number, number][];
  low: ([number, number, number] | null)[];
  high: ([number, number, number] | null)[];
  borders: { pairs: [number, number][]; length: number[]; votes: (number | null)[] };
}

export interface Settings {
  [name: string]: string | number;
}

export type Source = { sample: string } | { scene: string } | { files: Map<string, File> };

export class Refused extends Error {}

async function answer(response: Response): Promise<Response> {
  if (response.ok) return response;
  let text = `the server answered ${response.status}`;
  try {
    text = ((await response.json()) as { error: string }).error;
  } catch {
    // The status has to do.
  }
  throw new Refused(text);
}

async function ask(path: string, init?: RequestInit): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new Refused("the server cannot be reached: is geohue serve still running?");
  }
  return answer(response);
}

export async function about(): Promise<About> {
  return (await (await ask("/api/about")).json()) as About;
}

export async function submit(source: Source, settings: Settings): Promise<Status> {
  let init: RequestInit;
  if ("files" in source) {
    const body = new FormData();
    body.set("settings", JSON.stringify(settings));
    for (const [role, file] of source.files) body.set(role, file, file.name);
    init = { method: "POST", body };
  } else {
    const headers = { "Content-Type": "application/json" };
    init = { method: "POST", headers, body: JSON.stringify({ ...source, settings }) };
  }
  return (await (await ask("/api/jobs", init)).json()) as Status;
}

/** Tells of every change of a job until it ends. */
export function follow(id: string, tell: (status: Status) => void): Promise<Status> {
  return new Promise((resolve, reject) => {
    const events = new EventSource(`/api/jobs/${id}/events`);
    events.addEventListener("progress", (event) => {
      const status = JSON.parse((event as MessageEvent<string>).data) as Status;
      tell(status);
      if (["done", "failed", "cancelled"].includes(status.state)) {
        events.close();
        resolve(status);
      }
    });
    events.addEventListener("error", () => {
      events.close();
      reject(new Refused("the server cannot be reached: is geohue serve still running?"));
    });
  });
}

export async function cancel(id: string): Promise<void> {
  await ask(`/api/jobs/${id}/cancel`, { method: "POST" });
}

/** Removes a job's files; also while the page is being closed. */
export function forget(id: string): void {
  void fetch(`/api/jobs/${id}`, { method: "DELETE", keepalive: true }).catch(() => undefined);
}

export async function result(id: string): Promise<Summary> {
  return (await (await ask(`/api/jobs/${id}/result`)).json()) as Summary;
}

export async function view(id: string): Promise<View> {
  return (await (await ask(`/api/jobs/${id}/data/view`)).json()) as View;
}

export async function bytes(id: string, name: string): Promise<ArrayBuffer> {
  return (await ask(`/api/jobs/${id}/data/${name}`)).arrayBuffer();
}

export async function picture(id: string): Promise<ImageBitmap> {
  const blob = await (await ask(`/api/jobs/${id}/data/color`)).blob();
  return createImageBitmap(blob);
}

export interface Corrections {
  segment_of: number[];
  names: Record<string, string>;
}

/** Returns a file and its name. */
export async function take(id: string, format: string, what: Corrections): Promise<[Blob, string]> {
  const headers = { "Content-Type": "application/json" };
  const init = { method: "POST", headers, body: JSON.stringify(what) };
  const response = await ask(`/api/jobs/${id}/export/${format}`, init);
  const named = /filename="([^"]+)"/.exec(response.headers.get("Content-Disposition") ?? "");
  return [await response.blob(), named?.[1] ?? format];
}
