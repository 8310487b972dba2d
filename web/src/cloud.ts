// The cloud on the screen: its colours, its pace, and what lies under the pointer. The points lie in
// random order: the first of them stand for all, and fewer are drawn while the view turns.

import { colorOf } from "./colors";
import type { Look } from "./flat";
import { GlPainter } from "./gl";
import type { Orbit } from "./orbit";
import { NONE, TABLE, type Frame, type Paint, type Painter, type Seen } from "./painter";
import { PlainPainter } from "./plain";

const BYTES = 22; // of a point
const REACH = 4; // pixels around a pointer in which a point is looked for
const FEWEST = 20_000;
const FRAME = 1000 / 60;
const PATIENCE = 20; // frames in time before more points are tried
const REST = 160; // milliseconds without a change, then all points are drawn

export class Cloud {
  readonly canvas = document.createElement("canvas");
  private readonly painter: Painter;
  private readonly colors = new Uint8Array(4 * TABLE * TABLE);
  private readonly count: number;
  private budget: number;
  private inTime = 0; // frames since the last late one
  private paint: Paint = "segment";
  private hidden: ReadonlySet<number> | null = null;
  private picture: Seen | null = null;
  private request = 0;
  private lastFrame = 0;
  private lastChange = 0;

  constructor(
    points: ArrayBuffer,
    private readonly regions: number,
    private readonly orbit: Orbit,
  ) {
    this.count = points.byteLength / BYTES;
    this.budget = Math.min(this.count, 100_000);
    this.painter =
      GlPainter.on(this.canvas, points, this.count) ?? new PlainPainter(this.canvas, points, this.count);
    this.canvas.dataset["painter"] = this.painter instanceof GlPainter ? "gl" : "plain";
    this.orbit.onChange(() => this.wake());
    new ResizeObserver(() => this.wake()).observe(this.canvas);
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  }

  /** Colours each point anew: a small table changes, and no point. */
  show(paint: Paint, { now, safe, hovered, selected }: Look): void {
    this.paint = paint;
    if (this.hidden !== now.hidden) this.picture = null;
    this.hidden = now.hidden;
    for (let r = 0; r < this.regions; r++) {
      const s = now.segmentOf[r]!;
      const color = colorOf(s, safe);
      const glow = selected.has(s) ? 0.55 : s === hovered ? 0.3 : 0;
      for (let c = 0; c < 3; c++) this.colors[4 * r + c] = color[c]! + (255 - color[c]!) * glow;
      this.colors[4 * r + 3] = now.hidden.has(s) ? 0 : 255;
    }
    this.colors.fill(90, 4 * NONE, 4 * NONE + 3);
    this.colors[4 * NONE + 3] = now.hidden.size ? 0 : 255;
    this.painter.recolor(this.colors);
    this.wake(0);
  }

  /** The region of the point at a place given in shares of width and height; -1 for none. */
  regionAt(x: number, y: number): number {
    this.picture ??= this.painter.seen(this.frame(this.count));
    const { width, height, at } = this.picture;
    const [px, py] = [Math.floor(x * width), Math.floor(y * height)];
    let best = -1;
    let least = Infinity;
    for (let j = Math.max(py - REACH, 0); j <= Math.min(py + REACH, height - 1); j++) {
      for (let i = Math.max(px - REACH, 0); i <= Math.min(px + REACH, width - 1); i++) {
        const region = at(i, j);
        const away = Math.hypot(i - px, j - py);
        if (region !== NONE && away < least) [best, least] = [region, away];
      }
    }
    return best;
  }

  destroy(): void {
    cancelAnimationFrame(this.request);
    this.canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
  }

  private wake(at = performance.now()): void {
    if (at) {
      this.lastChange = at;
      this.picture = null;
    }
    if (!this.request) this.request = requestAnimationFrame((now) => this.step(now));
  }

  private step(now: number): void {
    this.request = 0;
    if (!this.canvas.isConnected || !this.canvas.clientWidth) return;
    const turning = now - this.lastChange < REST || this.orbit.isHeld;
    const since = now - this.lastFrame;
    this.lastFrame = now;
    if (turning && since < 250) {
      // Fewer points as soon as a frame comes late, slowly more while all come in time.
      const late = since > 1.4 * FRAME;
      this.inTime = late ? 0 : this.inTime + 1;
      const factor = late ? 0.8 : this.inTime > PATIENCE ? 1.02 : 1;
      this.budget = Math.max(Math.min(FEWEST, this.count), Math.min(this.count, this.budget * factor));
    }
    const frame = this.frame(turning ? Math.floor(this.budget) : this.count);
    if (this.canvas.width !== frame.width) this.canvas.width = frame.width;
    if (this.canvas.height !== frame.height) this.canvas.height = frame.height;
    this.painter.draw(frame, this.paint);
    this.canvas.dataset["drawn"] = String(frame.count);
    if (turning) this.request = requestAnimationFrame((next) => this.step(next));
  }

  private frame(count: number): Frame {
    const scale = Math.min(devicePixelRatio, 1.5);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    // Points of a surface just about touch, whatever the number that is drawn.
    const size = (1.1 * height) / this.orbit.distance / Math.sqrt(Math.max(count, 1));
    const matrix = this.orbit.matrix(width / height);
    return { count, width, height, size: Math.max(1.5, Math.min(9, size)), matrix };
  }
}
