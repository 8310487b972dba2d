// The area where results are seen: one, or two with a divider between them.

import type { Paint } from "./painter";
import { input, select, show, the } from "./dom";
import type { Look } from "./flat";
import type { Model } from "./model";
import { Orbit } from "./orbit";
import { Pane, type Mode } from "./pane";

const TITLES: Record<Mode, string> = {
  color: "Colour",
  depth: "Depth",
  segments: "Segments",
  borders: "Borders",
  votes: "Votes",
  "3d": "3-D",
};
const ORDER = Object.keys(TITLES) as Mode[];

const CLICK = 5; // pixels that a pointer may move in a click

export class Stage {
  mode: Mode = "segments";
  hovered = -1;
  readonly selected = new Set<number>();
  private readonly orbit = new Orbit();
  private panes: Pane[] = [];
  private readonly line = document.createElement("div");
  private readonly tags = [document.createElement("span"), document.createElement("span")];
  private pressed: [number, number] = [0, 0];

  constructor(private readonly changed: () => void) {
    this.line.className = "line";
    this.tags.forEach((tag, i) => (tag.className = `tag ${i ? "other" : "one"}`));
    const area = the("panes");
    area.addEventListener("pointermove", (event) => this.point(event));
    area.addEventListener("pointerleave", () => this.hover(-1));
    area.addEventListener("pointerdown", (event) => (this.pressed = [event.clientX, event.clientY]));
    area.addEventListener("pointerup", (event) => this.click(event));
    input("divider").addEventListener("input", () => this.divide());
    the("modes").addEventListener("keydown", (event) => this.step(event));
    for (const id of ["paint", "safe"]) the(id).addEventListener("change", () => this.draw());
  }

  get main(): Model | null {
    return this.panes[0]?.model ?? null;
  }

  get modes(): Mode[] {
    return this.panes[0]?.modes ?? [];
  }

  /** Shows one result, or two. */
  put(models: Model[], keepSelection = false): void {
    const kept = this.panes.filter((pane) => models.includes(pane.model));
    for (const pane of this.panes) if (!kept.includes(pane)) pane.destroy();
    this.panes = models.map((m) => kept.find((p) => p.model === m) ?? new Pane(m, this.orbit));
    if (!keepSelection) this.selected.clear();
    this.hovered = -1;
    const two = this.panes.length === 2;
    the("panes").replaceChildren(...this.panes.map((p) => p.element), ...(two ? [this.line, ...this.tags] : []));
    models.forEach((m, i) => (this.tags[i]!.textContent = m.title));
    show("empty", models.length === 0);
    show("panes", models.length > 0);
    show("divider", two);
    if (!this.modes.includes(this.mode)) {
      this.mode = this.modes.includes("segments") ? "segments" : (this.modes[0] ?? "3d");
    }
    this.choices();
    this.divide();
    this.draw();
  }

  choose(mode: Mode): void {
    if (!this.modes.includes(mode)) return;
    this.mode = mode;
    this.choices();
    this.draw();
  }

  /** Draws, and notes on the page how long it took and how many points were drawn. */
  draw(): void {
    let spent = 0;
    this.panes.forEach((pane, i) => {
      spent += pane.draw(this.mode, select("paint").value as Paint, this.look(pane.model, i));
    });
    show("painting", this.mode === "3d");
    the("panes").dataset["ms"] = spent.toFixed(1);
  }

  private look(model: Model, i: number): Look {
    const none = new Set<number>();
    const [hovered, selected] = i ? [-1, none] : [this.hovered, this.selected];
    return { now: model.edits.now, safe: input("safe").checked, hovered, selected };
  }

  private choices(): void {
    const buttons = ORDER.filter((mode) => this.modes.includes(mode)).map((mode) => {
      const made = document.createElement("button");
      const on = mode === this.mode;
      made.type = "button";
      made.textContent = TITLES[mode];
      made.setAttribute("role", "radio");
      made.setAttribute("aria-checked", String(on));
      made.tabIndex = on ? 0 : -1;
      made.dataset["mode"] = mode;
      made.addEventListener("click", () => this.choose(mode));
      return made;
    });
    the("modes").replaceChildren(...buttons);
  }

  private step(event: KeyboardEvent): void {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const at = this.modes.indexOf(this.mode);
    this.choose(this.modes[(at + by + this.modes.length) % this.modes.length]!);
    the("modes").querySelector<HTMLElement>("[aria-checked=true]")?.focus();
  }

  private divide(): void {
    const share = input("divider").value;
    const second = this.panes[1]?.element;
    if (second) second.style.clipPath = `inset(0 0 0 ${share}%)`;
    this.line.style.left = `${share}%`;
  }

  private segmentAt(event: MouseEvent): number {
    const region = this.panes[0]?.regionAt(event, this.mode) ?? -1;
    return region < 0 ? -1 : this.main!.edits.now.segmentOf[region]!;
  }

  private point(event: PointerEvent): void {
    if (event.buttons || event.pointerType === "touch") return;
    this.hover(this.segmentAt(event));
  }

  private hover(segment: number): void {
    if (segment === this.hovered) return;
    this.hovered = segment;
    this.draw();
    this.changed();
  }

  private click(event: PointerEvent): void {
    const [x, y] = this.pressed;
    if (Math.hypot(event.clientX - x, event.clientY - y) > CLICK || event.button) return;
    this.pick(this.segmentAt(event), event.shiftKey || event.ctrlKey || event.metaKey);
  }

  /** Selects a segment: alone, or beside the others. */
  pick(segment: number, beside: boolean): void {
    const was = this.selected.has(segment);
    if (!beside) this.selected.clear();
    if (segment >= 0 && !(was && beside)) this.selected.add(segment);
    if (was && beside) this.selected.delete(segment);
    this.draw();
    this.changed();
  }
}
