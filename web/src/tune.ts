// The detail slider, which walks the tree here, and the curve of Q with its cuts.

import { drawCurve } from "./curve";
import { input, show, the } from "./dom";
import type { Now } from "./edits";
import type { Model } from "./model";
import { mergesAt } from "./tree";

const STEP = 0.02; // of the slider
const WIDEST = 8; // degrees of detail at the ends of the slider

export class Tuning {
  private before: Now | null = null;

  constructor(
    private readonly model: () => Model | null,
    private readonly drawn: () => void,
    private readonly settled: () => void,
    private readonly cutAt: (weight: number) => void,
  ) {
    input("detail").addEventListener("input", () => this.walk());
    input("detail").addEventListener("change", () => this.settle());
    input("weights").addEventListener("input", () => this.mark());
    input("weights").addEventListener("change", () => this.cutAt(this.curve[this.place]![0]));
  }

  /** Sets the slider to what a result shows, and draws its curve. */
  refresh(): void {
    const model = this.model();
    if (!model) return;
    const { heights } = model.view;
    show("walking", model.hasLevels);
    show("nolevels", !model.hasLevels);
    if (model.hasLevels) {
      const slider = input("detail");
      // In whole steps, so that 0 is one of them.
      slider.min = (Math.floor(Math.max(-WIDEST, -(heights.at(-1)! + 0.1)) / STEP) * STEP).toFixed(2);
      slider.max = (Math.ceil(Math.min(WIDEST, -heights[0]! + 0.1) / STEP) * STEP).toFixed(2);
      if (!this.before) slider.value = String(this.detailOf(model));
      this.count(model);
    }
    show("curvebox", this.curve.length > 1);
    if (this.curve.length > 1) {
      input("weights").max = String(this.curve.length - 1);
      const shown = model.summary.weight ?? 0;
      const place = this.curve.findIndex(([w]) => Math.abs(w - shown) < 1e-9 * Math.max(1, w));
      if (place >= 0) input("weights").value = String(place);
      this.mark();
    }
  }

  /** Weights and their quality, of the result whose cuts are being looked at. */
  curve: [number, number][] = [];

  private get place(): number {
    return Math.max(0, Math.min(this.curve.length - 1, Number(input("weights").value)));
  }

  private mark(): void {
    const now = this.curve[this.place]!;
    const best = this.curve.reduce((a, b) => (b[1] > a[1] ? b : a));
    the("weight").textContent = `${now[0].toPrecision(3)}, Q ${now[1].toFixed(3)}`;
    drawCurve(the("curve"), this.curve, best[0], now[0]);
  }

  private walk(): void {
    const model = this.model();
    if (!model) return;
    const begin = performance.now();
    this.before ??= model.edits.now;
    model.edits.walk(mergesAt(model.view, Number(input("detail").value)), null);
    this.count(model);
    this.drawn();
    the("detail").dataset["ms"] = (performance.now() - begin).toFixed(1);
  }

  private settle(): void {
    const model = this.model();
    if (!model) return;
    const before = this.before ?? model.edits.now;
    this.before = null;
    model.edits.walk(mergesAt(model.view, Number(input("detail").value)), before);
    this.settled();
  }

  private count(model: Model): void {
    const n = model.edits.segments.length;
    const text = `${n} segment${n === 1 ? "" : "s"}`;
    the("count").textContent = text;
    const detail = Number(input("detail").value);
    input("detail").setAttribute("aria-valuetext", `detail ${detail.toFixed(2)}, ${text}`);
  }

  /** A degree of detail with as many merges as are shown. */
  private detailOf(model: Model): number {
    const { heights } = model.view;
    const done = model.edits.now.merges;
    const low = done > 0 ? heights[done - 1]! : heights[0]! - 0.1;
    const high = done < heights.length ? heights[done]! : heights.at(-1)! + 0.1;
    return -(low < 0 && high >= 0 ? 0 : (low + high) / 2);
  }
}
