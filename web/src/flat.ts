// The pictures of a grid: colour, depth, segments, borders, votes.

import type { View } from "./api";
import { colorOf, ramp, type Color } from "./colors";
import type { Now } from "./edits";
import { heightsOf } from "./tree";

export type FlatMode = "color" | "depth" | "segments" | "borders" | "votes";

export interface Look {
  now: Now;
  safe: boolean;
  hovered: number;
  selected: ReadonlySet<number>;
}

const NONE = 65535;
const MOST_PIXELS = 1_600_000; // of what is shown: the slider must stay quick
const INK: Color = [120, 0, 60];

export class Flat {
  readonly width: number;
  readonly height: number;
  readonly step: number;
  private readonly rgb: Uint8ClampedArray;
  private readonly grey: Uint8Array;
  private readonly regions: Uint16Array;
  private readonly depth: Float32Array | null;
  private readonly edge: Int32Array; // pixels on a border of two regions
  private readonly pair: Int32Array; // and the border of each
  private readonly chance: Float64Array; // that a border parts two things
  private readonly out: ImageData;

  constructor(
    private readonly view: View,
    image: ImageBitmap,
    regions: Uint16Array,
    depth: Float32Array | null,
  ) {
    const [rows, columns] = view.shape as [number, number];
    this.step = Math.max(1, Math.ceil(Math.sqrt((rows * columns) / MOST_PIXELS)));
    this.width = Math.ceil(columns / this.step);
    this.height = Math.ceil(rows / this.step);
    this.regions = this.thinned(regions, columns, Uint16Array);
    this.depth = depth && this.thinned(depth, columns, Float32Array);
    this.rgb = this.pixelsOf(image);
    this.grey = new Uint8Array(this.width * this.height);
    for (let i = 0, p = 0; i < this.grey.length; i++, p += 4) {
      this.grey[i] = (this.rgb[p]! + this.rgb[p + 1]! + this.rgb[p + 2]!) / 3;
    }
    [this.edge, this.pair] = this.borders();
    this.chance = heightsOf(view, view.borders.pairs).map((h) => 1 / (1 + Math.exp(-h)));
    this.out = new ImageData(this.width, this.height);
  }

  /** The region at a place given in shares of width and height; -1 for none. */
  regionAt(x: number, y: number): number {
    const column = Math.floor(x * this.width);
    const row = Math.floor(y * this.height);
    if (column < 0 || row < 0 || column >= this.width || row >= this.height) return -1;
    const region = this.regions[row * this.width + column]!;
    return region === NONE ? -1 : region;
  }

  draw(canvas: HTMLCanvasElement, mode: FlatMode, look: Look): void {
    if (canvas.width !== this.width) canvas.width = this.width;
    if (canvas.height !== this.height) canvas.height = this.height;
    if (mode === "color") this.out.data.set(this.rgb);
    else if (mode === "depth") this.paintDepth();
    else if (mode === "segments") this.paintSegments(look);
    else this.paintBorders(mode, look);
    canvas.getContext("2d")!.putImageData(this.out, 0, 0);
  }

  private thinned<T extends Uint16Array | Float32Array>(
    all: T,
    columns: number,
    make: new (n: number) => T,
  ): T {
    if (this.step === 1) return all;
    const some = new make(this.width * this.height);
    for (let y = 0, i = 0; y < this.height; y++) {
      for (let x = 0; x < this.width; x++, i++) some[i] = all[(y * columns + x) * this.step]!;
    }
    return some;
  }

  private pixelsOf(image: ImageBitmap): Uint8ClampedArray {
    const canvas = document.createElement("canvas");
    canvas.width = this.width;
    canvas.height = this.height;
    const context = canvas.getContext("2d", { willReadFrequently: true })!;
    context.drawImage(image, 0, 0, this.width, this.height);
    image.close();
    return context.getImageData(0, 0, this.width, this.height).data;
  }

  private borders(): [Int32Array, Int32Array] {
    const n = this.view.n_regions;
    const index = new Map(this.view.borders.pairs.map(([a, b], i) => [a * n + b, i]));
    const edge: number[] = [];
    const pair: number[] = [];
    const look = (i: number, j: number): boolean => {
      const [a, b] = [this.regions[i]!, this.regions[j]!];
      if (a === b || a === NONE || b === NONE) return false;
      const found = index.get(Math.min(a, b) * n + Math.max(a, b));
      if (found === undefined) return false;
      edge.push(i);
      pair.push(found);
      return true;
    };
    for (let y = 0, i = 0; y < this.height; y++) {
      for (let x = 0; x < this.width; x++, i++) {
        if (x + 1 < this.width) look(i, i + 1);
        if (y + 1 < this.height) look(i, i + this.width);
      }
    }
    return [Int32Array.from(edge), Int32Array.from(pair)];
  }

  private paintDepth(): void {
    const data = this.out.data;
    const [near, far] = this.view.depth ?? [0, 1];
    const table = Array.from({ length: 256 }, (_, i) => ramp(1 - i / 255));
    const scale = 255 / Math.max(far - near, 1e-9);
    for (let i = 0, p = 0; i < this.grey.length; i++, p += 4) {
      const z = this.depth ? this.depth[i]! : NaN;
      const color = z === z ? table[Math.max(0, Math.min(255, Math.round((z - near) * scale)))]! : [40, 40, 40];
      data[p] = color[0]!;
      data[p + 1] = color[1]!;
      data[p + 2] = color[2]!;
      data[p + 3] = 255;
    }
  }

  private paintSegments({ now, safe, hovered, selected }: Look): void {
    const n = this.view.n_regions;
    const tint = new Float32Array(4 * n); // colour times its share, and the share of grey
    for (let r = 0; r < n; r++) {
      const s = now.segmentOf[r]!;
      const color = colorOf(s, safe);
      const seen = now.hidden.has(s) ? 0.08 : selected.has(s) ? 0.8 : s === hovered ? 0.7 : 0.55;
      const grey = now.hidden.has(s) ? 0.12 : 1 - seen;
      for (let c = 0; c < 3; c++) tint[4 * r + c] = color[c]! * seen;
      tint[4 * r + 3] = grey;
    }
    const data = this.out.data;
    const { regions, grey, width } = this;
    const of = now.segmentOf;
    let above = -1;
    for (let i = 0, p = 0; i < grey.length; i++, p += 4) {
      const r = regions[i]!;
      if (r === NONE) {
        data[p] = data[p + 1] = data[p + 2] = 40;
        data[p + 3] = 255;
        continue;
      }
      const s = of[r]!;
      const left = i % width ? regions[i - 1]! : NONE;
      above = i >= width ? regions[i - width]! : NONE;
      if ((left !== NONE && of[left] !== s) || (above !== NONE && of[above] !== s)) {
        data[p] = data[p + 1] = data[p + 2] = data[p + 3] = 255;
        continue;
      }
      const base = grey[i]! * tint[4 * r + 3]!;
      data[p] = base + tint[4 * r]!;
      data[p + 1] = base + tint[4 * r + 1]!;
      data[p + 2] = base + tint[4 * r + 2]!;
      data[p + 3] = 255;
    }
  }

  /** Borders as dark as they are certain, or in the colour of the share of cuts that draw them. */
  private paintBorders(mode: "borders" | "votes", { now }: Look): void {
    const data = this.out.data;
    for (let i = 0, p = 0; i < this.grey.length; i++, p += 4) {
      data[p] = data[p + 1] = data[p + 2] = 191 + 0.25 * this.grey[i]!;
      data[p + 3] = 255;
    }
    const { pairs, votes } = this.view.borders;
    for (let e = 0; e < this.edge.length; e++) {
      const i = this.edge[e]!;
      const b = this.pair[e]!;
      const [one, other] = pairs[b]!;
      const apart = now.segmentOf[one] !== now.segmentOf[other];
      const share = mode === "borders" ? this.chance[b]! : votes[b] ?? null;
      if (share === null) continue;
      const color = mode === "borders" ? INK : ramp(1 - share);
      const ink = mode === "borders" ? share : 0.25 + 0.75 * share;
      this.dot(i, color, ink);
      if (apart) {
        this.dot(i + 1, color, ink);
        this.dot(i + this.width, color, ink);
      }
    }
  }

  private dot(i: number, color: Color, ink: number): void {
    if (i >= this.grey.length) return;
    const data = this.out.data;
    const base = 191 + 0.25 * this.grey[i]!;
    for (let c = 0; c < 3; c++) {
      const value = base * (1 - ink) + color[c]! * ink;
      if (value < data[4 * i + c]!) data[4 * i + c] = value;
    }
  }
}
