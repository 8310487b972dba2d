// One result on the screen: its pictures and its cloud.

import { Cloud } from "./cloud";
import type { FlatMode, Look } from "./flat";
import type { Model } from "./model";
import type { Orbit } from "./orbit";
import type { Paint } from "./painter";

export type Mode = FlatMode | "3d";

export class Pane {
  readonly element = document.createElement("div");
  private readonly flat = document.createElement("canvas");
  private cloud: Cloud | null = null;

  constructor(
    readonly model: Model,
    private readonly orbit: Orbit,
  ) {
    this.element.className = "pane";
    this.flat.className = "flat";
    this.flat.setAttribute("role", "img");
    this.element.append(this.flat);
  }

  get modes(): Mode[] {
    const modes: Mode[] = [];
    const { flat, view, points } = this.model;
    if (flat) {
      modes.push("color");
      if (view.depth) modes.push("depth");
      modes.push("segments");
      if (this.model.hasLevels) modes.push("borders");
      if (view.borders.votes.some((share) => share !== null)) modes.push("votes");
    }
    if (points) modes.push("3d");
    return modes;
  }

  /** Draws, and returns how many milliseconds that took. */
  draw(mode: Mode, paint: Paint, look: Look): number {
    const begin = performance.now();
    const solid = mode === "3d";
    this.flat.hidden = solid;
    if (solid) this.solid().show(paint, look);
    else this.model.flat?.draw(this.flat, mode, look);
    if (this.cloud) this.cloud.canvas.hidden = !solid;
    this.flat.setAttribute("aria-label", `${this.model.title}: ${mode}`);
    this.element.dataset["mode"] = mode;
    return performance.now() - begin;
  }

  /** The region under a pointer; -1 for none. */
  regionAt(event: { clientX: number; clientY: number }, mode: Mode): number {
    const canvas = mode === "3d" ? this.cloud?.canvas : this.flat;
    if (!canvas) return -1;
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    if (mode === "3d") return this.cloud!.regionAt(x / box.width, y / box.height);
    // The picture keeps its proportions within the canvas.
    const scale = Math.min(box.width / this.flat.width, box.height / this.flat.height);
    const left = (box.width - this.flat.width * scale) / 2;
    const top = (box.height - this.flat.height * scale) / 2;
    const [u, v] = [(x - left) / (this.flat.width * scale), (y - top) / (this.flat.height * scale)];
    return this.model.flat?.regionAt(u, v) ?? -1;
  }

  destroy(): void {
    this.cloud?.destroy();
    this.element.remove();
  }

  private solid(): Cloud {
    if (!this.cloud) {
      this.cloud = new Cloud(this.model.points!, this.model.view.n_regions, this.orbit);
      const canvas = this.cloud.canvas;
      canvas.tabIndex = 0;
      canvas.setAttribute("role", "img");
      canvas.setAttribute(
        "aria-label",
        `${this.model.title}: the cloud. Arrows turn it, with shift they move it, plus and minus zoom, 0 resets.`,
      );
      this.element.append(canvas);
      this.orbit.listen(canvas);
    }
    return this.cloud;
  }
}
