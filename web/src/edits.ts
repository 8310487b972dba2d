// The segments as they are now: which regions belong together, names, what is hidden; with undo.

import { named, numbers, parts, rootsAfter, type Tree } from "./tree";

export interface Now {
  readonly segmentOf: Int32Array;
  readonly names: ReadonlyMap<number, string>;
  readonly hidden: ReadonlySet<number>;
  readonly merges: number;
}

const DEEPEST = 200;

export class Edits {
  readonly number: Int32Array;
  now: Now;
  private ranked: [Now, ReadonlyMap<number, number>] | null = null;
  private before: Now[] = [];
  private after: Now[] = [];

  constructor(
    readonly tree: Tree,
    start: number,
  ) {
    this.number = numbers(tree);
    this.now = { segmentOf: this.level(start), names: new Map(), hidden: new Set(), merges: start };
  }

  get canUndo(): boolean {
    return this.before.length > 0;
  }

  get canRedo(): boolean {
    return this.after.length > 0;
  }

  /** Segments by size, the largest first, as [segment, points]. */
  get segments(): [number, number][] {
    const size = new Map<number, number>();
    this.now.segmentOf.forEach((s, r) => size.set(s, (size.get(s) ?? 0) + this.tree.size[r]!));
    return [...size].filter(([, n]) => n > 0).sort((a, b) => b[1] - a[1] || a[0] - b[0]);
  }

  /** The rank of each segment by size: its number in what is taken home. */
  get ranks(): ReadonlyMap<number, number> {
    if (this.ranked?.[0] !== this.now) {
      this.ranked = [this.now, new Map(this.segments.map(([s], i) => [s, i]))];
    }
    return this.ranked[1];
  }

  members(segment: number): number[] {
    const found: number[] = [];
    this.now.segmentOf.forEach((s, r) => {
      if (s === segment) found.push(r);
    });
    return found;
  }

  /** Shows a level of the tree; `settle` makes it a step that can be undone. */
  walk(merges: number, settle: Now | null): void {
    const next = { ...this.now, segmentOf: this.level(merges), merges };
    if (settle) {
      this.now = settle;
      this.step(next);
    } else this.now = next;
  }

  merge(segments: Iterable<number>): number {
    const chosen = new Set(segments);
    const least = Math.min(...chosen);
    const segmentOf = this.now.segmentOf.map((s) => (chosen.has(s) ? least : s));
    this.step({ ...this.now, segmentOf });
    return least;
  }

  /** Splits a segment along the next level; returns its parts, one if it cannot be split. */
  split(segment: number): number[] {
    const found = parts(this.tree, this.members(segment));
    if (found.length < 2) return [segment];
    const segmentOf = this.now.segmentOf.slice();
    const names = found.map((part) => {
      const least = Math.min(...part.map((r) => this.number[r]!));
      for (const r of part) segmentOf[r] = least;
      return least;
    });
    this.step({ ...this.now, segmentOf });
    return names;
  }

  hide(segments: Iterable<number>): void {
    this.step({ ...this.now, hidden: new Set([...this.now.hidden, ...segments]) });
  }

  /** Hides all others. */
  isolate(segments: ReadonlySet<number>): void {
    const others = new Set([...this.now.segmentOf].filter((s) => !segments.has(s)));
    this.step({ ...this.now, hidden: others });
  }

  showAll(): void {
    this.step({ ...this.now, hidden: new Set() });
  }

  rename(segment: number, name: string): void {
    const names = new Map(this.now.names);
    if (name) names.set(segment, name);
    else names.delete(segment);
    this.step({ ...this.now, names });
  }

  undo(): void {
    this.swap(this.before, this.after);
  }

  redo(): void {
    this.swap(this.after, this.before);
  }

  /** The segment of each region as a rank by size, and names by rank: what exports are told. */
  corrections(): { segment_of: number[]; names: Record<string, string> } {
    const rank = this.ranks;
    const names: Record<string, string> = {};
    for (const [s, name] of this.now.names) {
      const place = rank.get(s);
      if (place !== undefined) names[String(place)] = name;
    }
    return { segment_of: Array.from(this.now.segmentOf, (s) => rank.get(s) ?? -1), names };
  }

  private level(merges: number): Int32Array {
    return named(rootsAfter(this.tree, merges), this.number);
  }

  private step(next: Now): void {
    this.before.push(this.now);
    if (this.before.length > DEEPEST) this.before.shift();
    this.after = [];
    this.now = next;
  }

  private swap(from: Now[], to: Now[]): void {
    const next = from.pop();
    if (!next) return;
    to.push(this.now);
    this.now = next;
  }
}
