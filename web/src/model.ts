// One result as the page holds it: what was loaded, and the segments as they are now.

import * as api from "./api";
import { Edits } from "./edits";
import { Flat } from "./flat";

export interface Facts {
  size: number;
  share: number;
  color: [number, number, number];
  extent: [number, number, number] | null;
  neighbours: number[];
}

export class Model {
  readonly edits: Edits;

  private constructor(
    readonly id: string,
    readonly title: string,
    readonly summary: api.Summary,
    readonly view: api.View,
    readonly flat: Flat | null,
    readonly points: ArrayBuffer | null,
  ) {
    this.edits = new Edits(view, view.start);
  }

  static async load(id: string, title: string): Promise<Model> {
    const [summary, view] = await Promise.all([api.result(id), api.view(id)]);
    const grid = view.shape.length === 2;
    const [image, regions, depth, points] = await Promise.all([
      grid ? api.picture(id) : null,
      grid ? api.bytes(id, "regions") : null,
      grid && view.depth ? api.bytes(id, "depth") : null,
      view.points ? api.bytes(id, "points") : null,
    ]);
    const flat =
      image && regions
        ? new Flat(view, image, new Uint16Array(regions), depth && new Float32Array(depth))
        : null;
    return new Model(id, title, summary, view, flat, points);
  }

  get hasLevels(): boolean {
    return this.view.merges.length > 0;
  }

  facts(segment: number): Facts {
    const { size, color, low, high, borders } = this.view;
    const total = size.reduce((a, b) => a + b, 0);
    let n = 0;
    const mean: [number, number, number] = [0, 0, 0];
    const least = [Infinity, Infinity, Infinity];
    const most = [-Infinity, -Infinity, -Infinity];
    for (const r of this.edits.members(segment)) {
      n += size[r]!;
      for (let c = 0; c < 3; c++) {
        mean[c]! += size[r]! * color[r]![c]!;
        least[c] = Math.min(least[c]!, low[r]?.[c] ?? Infinity);
        most[c] = Math.max(most[c]!, high[r]?.[c] ?? -Infinity);
      }
    }
    const near = new Set<number>();
    const of = this.edits.now.segmentOf;
    for (const [a, b] of borders.pairs) {
      if (of[a] === segment && of[b] !== segment) near.add(of[b]!);
      if (of[b] === segment && of[a] !== segment) near.add(of[a]!);
    }
    const spans = most.map((v, c) => v - least[c]!) as [number, number, number];
    return {
      size: n,
      share: n / Math.max(total, 1),
      color: mean.map((v) => v / Math.max(n, 1)) as [number, number, number],
      extent: spans.every(Number.isFinite) ? spans : null,
      neighbours: [...near].sort((a, b) => a - b),
    };
  }

  nameOf(segment: number): string {
    const rank = this.edits.ranks.get(segment) ?? 0;
    return this.edits.now.names.get(segment) ?? `segment ${rank + 1}`;
  }
}
