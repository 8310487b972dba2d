// Points drawn by the main processor: several times as fast as a WebGL that it has to imitate.

import { ramp } from "./colors";
import { NONE, type Frame, type Paint, type Painter, type Seen } from "./painter";

const GROUND = 0xff171412;
const NEAREST = 1e-3;
const RAMP = Uint32Array.from({ length: 256 }, (_, i) => {
  const [r, g, b] = ramp(i / 255);
  return (255 << 24) | (b << 16) | (g << 8) | r;
});

export class PlainPainter implements Painter {
  private readonly context: CanvasRenderingContext2D;
  private readonly places: Float32Array;
  private readonly colors: Uint32Array;
  private readonly normals: Int8Array;
  private readonly regions: Uint16Array;
  private table: Uint8Array = new Uint8Array(0);
  private image: ImageData | null = null;
  private pixels = new Uint32Array(0);
  private depths = new Float32Array(0);
  private names = new Uint16Array(0);

  constructor(canvas: HTMLCanvasElement, points: ArrayBuffer, count: number) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("this browser cannot draw");
    this.context = context;
    this.places = new Float32Array(points, 0, 3 * count);
    this.colors = new Uint32Array(points, 12 * count, count);
    this.normals = new Int8Array(points, 16 * count, 4 * count);
    this.regions = new Uint16Array(points, 20 * count, count);
  }

  recolor(colors: Uint8Array): void {
    this.table = colors;
  }

  draw(frame: Frame, paint: Paint): void {
    const image = this.cleared(frame);
    const { matrix: m, count, width, height } = frame;
    const side = Math.max(1, Math.round(frame.size));
    const half = side >> 1;
    const { places, table, regions, depths, pixels, names } = this;
    const [m0, m1, m3, m4, m5, m7] = [m[0]!, m[1]!, m[3]!, m[4]!, m[5]!, m[7]!];
    const [m8, m9, m11, m12, m13, m15] = [m[8]!, m[9]!, m[11]!, m[12]!, m[13]!, m[15]!];
    for (let i = 0, p = 0; i < count; i++, p += 3) {
      const region = regions[i]!;
      if (table[4 * region + 3] === 0) continue;
      const x = places[p]!;
      const y = places[p + 1]!;
      const z = places[p + 2]!;
      const w = m3 * x + m7 * y + m11 * z + m15;
      if (w < NEAREST) continue;
      const column = (((m0 * x + m4 * y + m8 * z + m12) / w) * 0.5 + 0.5) * width - half;
      const row = (0.5 - ((m1 * x + m5 * y + m9 * z + m13) / w) * 0.5) * height - half;
      if (column < 0 || row < 0 || column >= width - side || row >= height - side) continue;
      const start = (row | 0) * width + (column | 0);
      let color = 0;
      for (let dy = 0; dy < side; dy++) {
        for (let at = start + dy * width, end = at + side; at < end; at++) {
          if (w >= depths[at]!) continue;
          if (color === 0) color = this.shade(i, region, z, paint, m3, m7, m11);
          depths[at] = w;
          pixels[at] = color;
          names[at] = region;
        }
      }
    }
    this.context.putImageData(image, 0, 0);
  }

  /** What the last frame showed. */
  seen({ width, height }: Frame): Seen {
    return { width, height, at: (x, y) => this.names[y * width + x] ?? NONE };
  }

  private cleared({ width, height }: Frame): ImageData {
    if (this.image?.width !== width || this.image.height !== height) {
      this.image = new ImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      this.depths = new Float32Array(width * height);
      this.names = new Uint16Array(width * height);
    }
    this.pixels.fill(GROUND);
    this.depths.fill(Infinity);
    this.names.fill(NONE);
    return this.image;
  }

  private shade(i: number, region: number, z: number, paint: Paint, a: number, b: number, c: number): number {
    const { normals, table } = this;
    const [x, y, n] = [normals[4 * i]!, normals[4 * i + 1]!, normals[4 * i + 2]!];
    if (paint === "color") return this.colors[i]!;
    if (paint === "depth") return RAMP[Math.max(0, Math.min(255, Math.round(127.5 + 127.5 * z)))]!;
    if (paint === "normals") return (255 << 24) | ((127 + n) << 16) | ((127 + y) << 8) | (127 + x);
    const plain = x === 0 && y === 0 && n === 0;
    const light = plain ? 1 : 0.72 + 0.0022 * Math.abs(a * x + b * y + c * n);
    const t = 4 * region;
    return (255 << 24) | ((table[t + 2]! * light) << 16) | ((table[t + 1]! * light) << 8) | (table[t]! * light);
  }
}
