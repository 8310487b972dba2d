// The settings and the roles of files.

import type { About, Settings } from "./api";
import { input, offer, select, the } from "./dom";
import type { Files, Frame } from "./files";

const TEXTS = ["depth_scale", "intrinsics", "disparity_scale", "calib"];

export function prepare(about: About): void {
  offer(select("sample"), about.samples);
  offer(select("preset"), about.presets);
  offer(select("cues"), about.cues);
  offer(select("method"), about.methods);
  select("preset").value = "best";
  const { upload_bytes, pixels, points, keep_seconds } = about.limits;
  const millions = (n: number): string => (n / 1e6).toLocaleString("en", { maximumSignificantDigits: 3 });
  the("limits").textContent =
    `At most ${(upload_bytes / 2 ** 20).toFixed(0)} MB, ${millions(pixels)} million pixels or ` +
    `${millions(points)} million points a scene. Files are removed ${Math.round(keep_seconds / 60)} ` +
    `minutes after their last use. geohue ${about.version}.`;
  const against = select("against");
  for (const preset of about.presets) against.add(new Option(`preset ${preset}`, `preset:${preset}`));
  for (const method of about.methods.slice(1)) against.add(new Option(method, `method:${method}`));
  against.add(new Option("colour alone", "cues:color"));
  against.add(new Option("geometry alone", "cues:geometry"));
  against.value = "preset:paper";
}

function number(text: string): string | number {
  const value = Number(text);
  return text.trim() !== "" && Number.isFinite(value) ? value : text.trim();
}

/** The settings of the form; for a picture alone, by its colours. */
export function settings(frame: Frame | null): Settings {
  const alone = frame && frame.files.has("color") && !frame.files.has("depth") && !frame.files.has("right");
  const chosen: Settings = {
    preset: select("preset").value,
    k: number(input("k").value || "auto"),
    weight: number(input("lambda").value || "auto"),
    cues: alone ? "color" : select("cues").value,
    method: select("method").value,
    seed: Number(input("seed").value || "0"),
  };
  for (const name of TEXTS) {
    const text = input(name).value.trim();
    if (text) chosen[name] = text;
  }
  return chosen;
}

/** Lists the files of a scene, each with its role to be corrected. */
export function listRoles(files: Files, roles: string[]): void {
  const rows = [...files].map(([role, file]) => {
    const row = document.createElement("li");
    const label = document.createElement("label");
    const choice = document.createElement("select");
    offer(choice, roles);
    choice.value = role;
    choice.addEventListener("change", () => swapRole(files, role, choice.value, roles));
    label.append(file.name, choice);
    row.append(label);
    return row;
  });
  the("roles").replaceChildren(...rows);
}

/** Gives a file another role; the file that had it takes the first one's. */
function swapRole(files: Files, from: string, to: string, roles: string[]): void {
  const [one, other] = [files.get(from)!, files.get(to)];
  files.delete(from);
  if (other) files.set(from, other);
  files.set(to, one);
  listRoles(files, roles);
}
