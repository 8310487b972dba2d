// The cloud in plain WebGL 2. The points lie in random order: the first of them stand for all.

import { colorOf } from "./colors";
import type { Look } from "./flat";
import type { Orbit } from "./orbit";

export type Paint = "segment" | "color" | "depth" | "normals";

const PAINTS: Paint[] = ["segment", "color", "depth", "normals"];
const PICK = 4;
const NONE = 65535;
const TABLE = 256; // side of the texture with a colour for each region
const REACH = 2; // pixels around a pointer in which a point is looked for
const MOST_PICKED = 300_000;
const FEWEST = 20_000;
const FRAME = 1000 / 60;
const PATIENCE = 20; // frames in time before more points are tried
const REST = 160; // milliseconds without a change, then all points are drawn

const VERTEX = `#version 300 es
precision highp float;
in vec3 position;
in vec3 color;
in vec3 normal;
in uint region;
uniform mat4 view;
uniform float size;
uniform int paint;
uniform highp sampler2D table;
out vec3 shade;
vec3 ramp(float t) {
  vec3 a = vec3(0.2777, 0.0054, 0.3341) + t * (vec3(0.1051, 1.4046, 1.3846) +
    t * (vec3(-0.3309, 0.2148, 0.0951) + t * (vec3(-4.6342, -5.7991, -19.3324) +
    t * (vec3(6.2283, 14.1799, 56.6906) + t * (vec3(4.7764, -13.7451, -65.3530) +
    t * vec3(-5.4355, 4.6459, 26.3124))))));
  return clamp(a, 0.0, 1.0);
}
void main() {
  vec4 own = texelFetch(table, ivec2(int(region) & 255, int(region) >> 8), 0);
  gl_Position = view * vec4(position, 1.0);
  gl_PointSize = size;
  if (own.a == 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  vec3 eye = vec3(view[0][3], view[1][3], view[2][3]);
  float light = dot(normal, normal) > 0.0 ? 0.72 + 0.28 * abs(dot(normalize(normal), eye)) : 1.0;
  if (paint == 0) shade = own.rgb * light;
  else if (paint == 1) shade = color;
  else if (paint == 2) shade = ramp(0.5 + 0.5 * position.z);
  else if (paint == 3) shade = 0.5 + 0.5 * normal;
  else shade = vec3(float(region & 255u), float(region >> 8), 255.0) / 255.0;
}`;

const FRAGMENT = `#version 300 es
precision mediump float;
in vec3 shade;
out vec4 pixel;
void main() { pixel = vec4(shade, 1.0); }`;

interface Seen {
  key: number;
  width: number;
  height: number;
  pixels: Uint8Array;
}

export class Cloud {
  readonly canvas = document.createElement("canvas");
  private readonly gl: WebGL2RenderingContext;
  private readonly program: WebGLProgram;
  private readonly table: WebGLTexture;
  private readonly colors = new Uint8Array(4 * TABLE * TABLE);
  private readonly count: number;
  private budget: number;
  private inTime = 0; // frames since the last late one
  private paint: Paint = "segment";
  private hidden: ReadonlySet<number> | null = null;
  private version = 0;
  private picture: Seen | null = null;
  private request = 0;
  private lastFrame = 0;
  private lastChange = 0;

  constructor(
    points: ArrayBuffer,
    private readonly regions: number,
    private readonly orbit: Orbit,
  ) {
    const gl = this.canvas.getContext("webgl2", { antialias: false, powerPreference: "low-power" });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.program = this.compile();
    this.count = points.byteLength / 22;
    this.budget = Math.min(this.count, 100_000);
    this.table = gl.createTexture();
    this.fill(points);
    this.orbit.onChange(() => this.wake());
    new ResizeObserver(() => this.wake()).observe(this.canvas);
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  }

  /** Colours each point anew: a small table changes, and no point. */
  show(paint: Paint, { now, safe, hovered, selected }: Look): void {
    this.paint = paint;
    if (this.hidden !== now.hidden) this.version++;
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
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.table);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, TABLE, TABLE, 0, gl.RGBA, gl.UNSIGNED_BYTE, this.colors);
    this.wake(0);
  }

  /** The region of the point at a place given in shares of width and height; -1 for none. */
  regionAt(x: number, y: number): number {
    const seen = this.seen();
    const [px, py] = [Math.floor(x * seen.width), Math.floor((1 - y) * seen.height)];
    let best = -1;
    let least = Infinity;
    for (let j = Math.max(py - REACH, 0); j <= Math.min(py + REACH, seen.height - 1); j++) {
      for (let i = Math.max(px - REACH, 0); i <= Math.min(px + REACH, seen.width - 1); i++) {
        const p = 4 * (j * seen.width + i);
        const region = seen.pixels[p]! + 256 * seen.pixels[p + 1]!;
        const away = Math.hypot(i - px, j - py);
        // Blue tells a point from the background.
        if (seen.pixels[p + 2] === 255 && region !== NONE && away < least) [best, least] = [region, away];
      }
    }
    return best;
  }

  /** A small picture of the regions, drawn anew only when the view or what is hidden changes. */
  private seen(): Seen {
    if (this.picture?.key === this.version) return this.picture;
    const gl = this.gl;
    const width = Math.max(1, Math.round(this.canvas.clientWidth / 2));
    const height = Math.max(1, Math.round(this.canvas.clientHeight / 2));
    const [frame, color, depth] = [gl.createFramebuffer(), gl.createRenderbuffer(), gl.createRenderbuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (const [buffer, kind, place] of [
      [color, gl.RGBA8, gl.COLOR_ATTACHMENT0],
      [depth, gl.DEPTH_COMPONENT16, gl.DEPTH_ATTACHMENT],
    ] as const) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, kind, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
    this.render(Math.min(this.count, MOST_PICKED), PICK, width, height);
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frame);
    gl.deleteRenderbuffer(color);
    gl.deleteRenderbuffer(depth);
    this.picture = { key: this.version, width, height, pixels };
    return this.picture;
  }

  wake(at = performance.now()): void {
    if (at) {
      this.lastChange = at;
      this.version++;
    }
    if (!this.request) this.request = requestAnimationFrame((now) => this.frame(now));
  }

  destroy(): void {
    cancelAnimationFrame(this.request);
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  private frame(now: number): void {
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
    this.draw(turning ? Math.floor(this.budget) : this.count);
    if (turning) this.request = requestAnimationFrame((next) => this.frame(next));
  }

  private draw(count: number): void {
    const canvas = this.canvas;
    const scale = Math.min(devicePixelRatio, 1.5);
    const width = Math.max(1, Math.round(canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(canvas.clientHeight * scale));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    this.render(count, PAINTS.indexOf(this.paint), width, height);
    canvas.dataset["drawn"] = String(count);
  }

  private render(count: number, paint: number, width: number, height: number): void {
    const gl = this.gl;
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.program);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.07, 0.08, 0.09, paint === PICK ? 0 : 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const at = (name: string): WebGLUniformLocation | null => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix4fv(at("view"), false, this.orbit.matrix(width / height));
    // Points of a surface just about touch, whatever the number that is drawn.
    const size = (1.1 * height) / this.orbit.distance / Math.sqrt(Math.max(count, 1));
    gl.uniform1f(at("size"), Math.max(1.5, Math.min(9, size)));
    gl.uniform1i(at("paint"), paint);
    gl.bindTexture(gl.TEXTURE_2D, this.table);
    gl.drawArrays(gl.POINTS, 0, count);
  }

  private compile(): WebGLProgram {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(program) ?? "the shaders do not link");
    }
    return program;
  }

  /** Gives all points to the graphics memory, as the server packed them. */
  private fill(points: ArrayBuffer): void {
    const { gl, count } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
    const put = (name: string, size: number, type: number, scaled: boolean, stride: number, start: number): void => {
      const place = gl.getAttribLocation(this.program, name);
      if (place < 0) return;
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, scaled, stride, start);
    };
    put("position", 3, gl.FLOAT, false, 12, 0);
    put("color", 3, gl.UNSIGNED_BYTE, true, 4, 12 * count);
    put("normal", 3, gl.BYTE, true, 4, 16 * count);
    const place = gl.getAttribLocation(this.program, "region");
    gl.enableVertexAttribArray(place);
    gl.vertexAttribIPointer(place, 1, gl.UNSIGNED_SHORT, 2, 20 * count);
    gl.bindTexture(gl.TEXTURE_2D, this.table);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }
}
