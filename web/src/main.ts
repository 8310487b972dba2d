// The page: opens scenes, follows their jobs, and ties the parts together.

import * as api from "./api";
import { Corrections } from "./correct";
import { button, input, say, select, show, the } from "./dom";
import { framesOf, type Frame } from "./files";
import { listRoles, prepare, settings } from "./form";
import { Model } from "./model";
import { Stage } from "./stage";
import { Tuning } from "./tune";
import { describeResult, describeSegment } from "./words";

const EXPORTS: Record<string, string> = {
  labels: "Labels PNG",
  npy: "Labels NPY",
  ply: "PLY",
  las: "LAS",
  coco: "COCO",
  json: "JSON",
  report: "Report",
};
const GRID_ONLY = ["labels", "coco"];

class Page {
  private readonly stage = new Stage(() => this.refresh());
  private readonly corrections = new Corrections(this.stage, () => this.refresh());
  private readonly tuning = new Tuning(
    () => this.stage.main,
    () => this.stage.draw(),
    () => this.refresh(),
    (weight) => void this.cutAt(weight),
  );
  private readonly owned = new Set<string>();
  private readonly cuts = new Map<number, Model>();
  private frames: Frame[] = [];
  private at = 0;
  private sample = "";
  private used: api.Settings = {};
  private working = "";
  private turn = 0; // of what was asked for last: answers to earlier wishes are left alone

  constructor(private readonly about: api.About) {
    prepare(about);
    this.listen();
    for (const format of about.exports) {
      const made = document.createElement("button");
      made.type = "button";
      made.textContent = EXPORTS[format] ?? format;
      made.dataset["format"] = format;
      made.addEventListener("click", () => void this.export(format));
      the("exports").append(made);
    }
  }

  private listen(): void {
    for (const id of ["files", "folder"]) {
      input(id).addEventListener("change", () => {
        void this.open([...(input(id).files ?? [])]);
        input(id).value = "";
      });
    }
    select("sample").addEventListener("change", () => {
      this.sample = select("sample").value;
      this.frames = [];
      if (this.sample) void this.run();
    });
    const area = the("stagearea");
    for (const kind of ["dragenter", "dragover", "dragleave", "drop"]) {
      area.addEventListener(kind, (event) => {
        event.preventDefault();
        area.classList.toggle("over", kind === "dragenter" || kind === "dragover");
        if (kind === "drop") void dropped(event as DragEvent).then((files) => this.open(files));
      });
    }
    the("form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.run();
    });
    button("cancel").addEventListener("click", () => this.cancel());
    button("earlier").addEventListener("click", () => this.go(-1));
    button("later").addEventListener("click", () => this.go(1));
    button("compare").addEventListener("click", () => void this.compare());
    button("alone").addEventListener("click", () => this.show([this.stage.main!], true));
    input("safe").addEventListener("change", () => this.refresh());
    document.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("pagehide", (event) => {
      if (!event.persisted) for (const id of this.owned) api.forget(id);
    });
  }

  private async open(files: File[]): Promise<void> {
    if (files.length === 0) return;
    this.frames = await framesOf(files);
    this.at = 0;
    this.sample = "";
    select("sample").value = "";
    if (this.frames.length === 0) say("None of these files is a picture or a cloud that geohue reads.");
    else await this.run();
  }

  private go(by: number): void {
    const next = this.at + by;
    if (next < 0 || next >= this.frames.length) return;
    this.at = next;
    void this.run();
  }

  /** Segments the scene that is open with the settings of the form. */
  private async run(): Promise<void> {
    const frame = this.frames[this.at] ?? null;
    const source: api.Source = frame ? { files: frame.files } : { sample: this.sample };
    if (frame) {
      listRoles(frame.files, Object.keys(this.about.endings));
      const bytes = [...frame.files.values()].reduce((sum, file) => sum + file.size, 0);
      const most = this.about.limits.upload_bytes;
      if (bytes > most) {
        say(`The files have ${mb(bytes)}, more than ${mb(most)}: give a smaller scene.`);
        return;
      }
    } else if (!this.sample) {
      say("Open a scene first.");
      return;
    }
    show("frames", this.frames.length > 1);
    the("frame").textContent = frame ? `${this.at + 1} of ${this.frames.length}: ${frame.name}` : "";
    this.used = settings(frame);
    const model = await this.job(source, this.used, String(this.used["preset"]));
    if (!model) return;
    const old = [...this.owned].filter((id) => id !== model.id);
    this.tuning.curve = model.summary.weight_curve;
    this.cuts.clear();
    if (model.summary.weight !== null) this.cuts.set(model.summary.weight, model);
    this.show([model]);
    document.querySelector("aside")!.scrollTop = 0;
    for (const id of old) this.forget(id);
  }

  /** Runs a job, shown by the bar; null if it came to nothing or another was asked for since. */
  private async job(source: api.Source, wishes: api.Settings, title: string): Promise<Model | null> {
    const turn = ++this.turn;
    if (this.working) this.forget(this.working);
    this.working = "";
    say("");
    this.progress({ stage: "sending the files", progress: 0, before: 0 });
    try {
      const begun = await api.submit(source, wishes);
      this.owned.add(begun.id);
      if (turn !== this.turn) {
        this.forget(begun.id);
        return null;
      }
      this.working = begun.id;
      const ended = await api.follow(begun.id, (status) => turn === this.turn && this.progress(status));
      if (turn !== this.turn) return null;
      if (ended.state === "done") return await Model.load(begun.id, title);
      this.forget(begun.id);
      say(ended.state === "failed" ? (ended.error ?? "it failed") : "Cancelled.");
    } catch (error) {
      if (turn === this.turn) say(error instanceof Error ? error.message : String(error));
    } finally {
      if (turn === this.turn) {
        this.working = "";
        show("working", false);
      }
    }
    return null;
  }

  private progress({ stage, progress, before }: Pick<api.Status, "stage" | "progress" | "before">): void {
    show("working", true);
    const waits = before ? `waiting for ${before} other scene${before === 1 ? "" : "s"}` : "starting";
    the("stage").textContent = stage || waits;
    (the("progress") as HTMLProgressElement).value = progress;
  }

  private cancel(): void {
    if (this.working) void api.cancel(this.working).catch(() => undefined);
    else {
      this.turn++; // the files are still being sent
      show("working", false);
    }
  }

  private forget(id: string): void {
    this.owned.delete(id);
    api.forget(id);
  }

  private show(models: Model[], keepSelection = false): void {
    this.stage.put(models, keepSelection);
    for (const id of ["tuning", "correcting", "exporting", "comparing"]) {
      (the(id) as HTMLFieldSetElement).disabled = models.length === 0;
    }
    show("alone", models.length === 2);
    for (const made of the("exports").querySelectorAll("button")) {
      const format = made.dataset["format"]!;
      const main = models[0]!;
      made.hidden = !main.flat && GRID_ONLY.includes(format);
      if (["ply", "las"].includes(format)) made.disabled = !main.points;
    }
    this.refresh();
  }

  private refresh(): void {
    const model = this.stage.main;
    if (!model) return;
    the("told").textContent = describeResult(model);
    const { warnings } = model.summary;
    show("remarks", warnings.length > 0);
    the("notes").replaceChildren(
      ...warnings.map((text) => Object.assign(document.createElement("li"), { textContent: text })),
    );
    const { hovered } = this.stage;
    the("hover").textContent = hovered >= 0 ? describeSegment(model, hovered) : "\u00a0";
    this.corrections.refresh();
    this.tuning.refresh();
  }

  /** Shows the same scene by other settings beside this one. */
  private async compare(): Promise<void> {
    const main = this.stage.main;
    if (!main) return;
    const against = select("against");
    const [name, value] = against.value.split(":") as [string, string];
    const wishes: api.Settings = { seed: this.used["seed"] ?? 0, cues: this.used["cues"] ?? "fusion" };
    wishes[name] = value;
    if (name === "method") wishes["k"] = Math.min(255, main.edits.segments.length);
    const title = against.selectedOptions[0]!.text;
    const other = await this.job({ scene: main.id }, wishes, title);
    if (other && this.stage.main === main) this.show([main, other], true);
  }

  /** Shows the paper's cut at another weight of the curve, with as many segments. */
  private async cutAt(weight: number): Promise<void> {
    const main = this.stage.main;
    if (!main) return;
    let model = this.cuts.get(weight) ?? null;
    if (!model) {
      const wishes = { ...this.used, k: main.summary.k, weight };
      model = await this.job({ scene: main.id }, wishes, `${main.title.split(",")[0]}, weight ${weight.toPrecision(3)}`);
      if (!model) return;
      this.cuts.set(weight, model);
    }
    this.show([model]);
  }

  private async export(format: string): Promise<void> {
    const model = this.stage.main;
    if (!model) return;
    say("");
    try {
      const [blob, name] = await api.take(model.id, format, model.edits.corrections());
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    } catch (error) {
      say(error instanceof Error ? error.message : String(error));
    }
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (target.closest("input:not([type=range]):not([type=checkbox]), select")) return;
    const held = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    const does: Record<string, string> = {
      m: "merge", s: "split", i: "isolate", h: "hide", a: "showall", z: "undo", y: "redo",
    };
    if (held ? !["z", "y"].includes(key) : event.altKey) return;
    const mode = this.stage.modes[Number(key) - 1];
    if (!held && mode) this.stage.choose(mode);
    else if (does[key]) {
      event.preventDefault();
      button(held && event.shiftKey && key === "z" ? "redo" : does[key]).click();
    }
  }
}

function mb(bytes: number): string {
  return `${(bytes / 2 ** 20).toFixed(1)} MB`;
}

/** The files of a drop, also those in dropped folders. */
async function dropped(event: DragEvent): Promise<File[]> {
  const transfer = event.dataTransfer;
  if (!transfer) return [];
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null);
  if (entries.every((entry) => !entry?.isDirectory)) return [...transfer.files];
  const found = await Promise.all(entries.map((entry) => (entry ? within(entry) : [])));
  return found.flat();
}

async function within(entry: FileSystemEntry): Promise<File[]> {
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
    return [file];
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const found: File[] = [];
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return found;
    for (const inner of some) found.push(...(await within(inner)));
  }
}

api.about().then(
  (about) => {
    new Page(about);
    document.documentElement.dataset["ready"] = "yes";
  },
  (error: Error) => say(error.message),
);
