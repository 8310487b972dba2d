// What the page says of results and segments.

import type { Model } from "./model";

const count = (n: number, one: string): string => `${n.toLocaleString("en")} ${one}${n === 1 ? "" : "s"}`;

export function describeSegment(model: Model, segment: number): string {
  const { size, share, color, extent, neighbours } = model.facts(segment);
  const unit = model.view.shape.length === 2 ? "pixel" : "point";
  const near = neighbours.slice(0, 4).map((s) => model.nameOf(s)).join(", ");
  const more = neighbours.length > 4 ? ", …" : "";
  return [
    model.nameOf(segment),
    `${count(size, unit)} (${(100 * share).toFixed(1)} %)`,
    `mean colour ${color.map((c) => Math.round(c)).join(" ")}`,
    extent ? `extent ${extent.map((e) => e.toPrecision(3)).join(" × ")}` : "no geometry",
    neighbours.length ? `${count(neighbours.length, "neighbour")}: ${near}${more}` : "no neighbours",
  ].join(" · ");
}

export function describeResult(model: Model): string {
  const { k, timings_s, weight, quality } = model.summary;
  const words = [model.title, count(k, "segment"), `${(timings_s["total"] ?? 0).toFixed(2)} s`];
  if (weight !== null && !model.hasLevels) words.push(`weight ${weight.toPrecision(3)}`);
  if (quality !== null) words.push(`Q ${quality.toFixed(3)}`);
  return words.join(" · ");
}
