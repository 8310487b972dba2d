// The list of segments, and what can be done with the selected ones.

import { colorOf, hex } from "./colors";
import { button, input, the } from "./dom";
import type { Model } from "./model";
import type { Stage } from "./stage";
import { describeSegment } from "./words";

const MOST_ROWS = 300;

export class Corrections {
  private told = "";

  constructor(
    private readonly stage: Stage,
    private readonly changed: () => void,
  ) {
    const act = (id: string, what: () => void): void => button(id).addEventListener("click", what);
    act("merge", () => this.merge());
    act("split", () => this.split());
    act("isolate", () => this.edit((m) => m.edits.isolate(this.selected)));
    act("hide", () => this.edit((m) => m.edits.hide(this.selected)));
    act("showall", () => this.edit((m) => m.edits.showAll()));
    act("undo", () => this.edit((m) => m.edits.undo()));
    act("redo", () => this.edit((m) => m.edits.redo()));
    the("renaming").addEventListener("submit", (event) => {
      event.preventDefault();
      const [segment] = this.selected;
      if (segment !== undefined) this.edit((m) => m.edits.rename(segment, input("name").value.trim()));
    });
  }

  get selected(): Set<number> {
    return this.stage.selected;
  }

  merge(): void {
    if (this.selected.size < 2) return;
    this.edit((m) => this.reselect([m.edits.merge(this.selected)]));
  }

  split(): void {
    const [segment] = this.selected;
    if (segment === undefined) return;
    this.edit((m) => {
      const found = m.edits.split(segment);
      if (found.length > 1) this.reselect(found);
      else this.told = "This is one of the finest regions: nothing to split.";
    });
  }

  edit(change: (model: Model) => void): void {
    const model = this.stage.main;
    if (!model) return;
    this.told = "";
    change(model);
    const there = new Set(model.edits.now.segmentOf);
    for (const segment of this.selected) if (!there.has(segment)) this.selected.delete(segment);
    this.stage.draw();
    this.changed();
  }

  /** Lists the segments anew. */
  refresh(): void {
    const model = this.stage.main;
    if (!model) return;
    const rows = model.edits.segments.slice(0, MOST_ROWS).map(([s, n]) => this.row(model, s, n));
    const focused = (document.activeElement as HTMLElement | null)?.dataset["segment"];
    the("segments").replaceChildren(...rows);
    if (focused) the("segments").querySelector<HTMLElement>(`[data-segment="${focused}"]`)?.focus();
    this.state(model);
  }

  private state(model: Model): void {
    const [first] = this.selected;
    const n = this.selected.size;
    const { edits } = model;
    button("merge").disabled = n < 2;
    button("split").disabled = n !== 1 || !model.hasLevels || edits.members(first!).length < 2;
    for (const id of ["isolate", "hide"]) button(id).disabled = n === 0;
    button("showall").disabled = edits.now.hidden.size === 0;
    button("undo").disabled = !edits.canUndo;
    button("redo").disabled = !edits.canRedo;
    input("name").disabled = n !== 1;
    input("name").value = n === 1 ? (edits.now.names.get(first!) ?? "") : "";
    const words = n === 0 ? "Click a segment; with Shift or Ctrl several." : `${n} segments selected.`;
    the("selection").textContent = this.told || (n === 1 ? describeSegment(model, first!) : words);
  }

  private row(model: Model, segment: number, size: number): HTMLLIElement {
    const item = document.createElement("li");
    const made = document.createElement("button");
    const [swatch, name, count] = ["swatch", "name", "count"].map((kind) => {
      const part = document.createElement("span");
      part.className = kind;
      return part;
    }) as [HTMLElement, HTMLElement, HTMLElement];
    swatch.style.background = hex(colorOf(segment, input("safe").checked));
    name.textContent = model.nameOf(segment);
    count.textContent = size.toLocaleString("en");
    const hidden = model.edits.now.hidden.has(segment);
    item.className = hidden ? "gone" : "";
    made.type = "button";
    made.dataset["segment"] = String(segment);
    made.setAttribute("aria-pressed", String(this.selected.has(segment)));
    if (hidden) count.textContent += " hidden";
    made.append(swatch, name, count);
    made.addEventListener("click", (event) =>
      this.stage.pick(segment, event.shiftKey || event.ctrlKey || event.metaKey),
    );
    item.append(made);
    return item;
  }

  private reselect(segments: number[]): void {
    this.selected.clear();
    for (const segment of segments) this.selected.add(segment);
  }
}
