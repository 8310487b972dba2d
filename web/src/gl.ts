// Points drawn by the graphics processor, in plain WebGL 2.

import { NONE, PAINTS, TABLE, type Frame, type Paint, type Painter, type Seen } from "./painter";

const PICK = PAINTS.length;
const MOST_PICKED = 300_000;
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i;

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


export class GlPainter implements Painter {
  private readonly program: WebGLProgram;
  private readonly table: WebGLTexture;

  private constructor(
    private readonly gl: WebGL2RenderingContext,
    points: ArrayBuffer,
    private readonly count: number,
  ) {
    this.program = this.compile();
    this.table = gl.createTexture();
    this.fill(points);
  }

  /** Returns none where WebGL 2 is missing, or only imitated, slowly, by the main processor. */
  static on(canvas: HTMLCanvasElement, points: ArrayBuffer, count: number): GlPainter | null {
    const probe = document.createElement("canvas").getContext("webgl2");
    const facts = probe?.getExtension("WEBGL_debug_renderer_info");
    const name = probe && facts ? String(probe.getParameter(facts.UNMASKED_RENDERER_WEBGL)) : "";
    probe?.getExtension("WEBGL_lose_context")?.loseContext();
    const forced = new URLSearchParams(location.search).get("draw");
    if (!probe || (forced ?? (SOFTWARE.test(name) ? "plain" : "gl")) === "plain") return null;
    const gl = canvas.getContext("webgl2", { antialias: false, powerPreference: "low-power" });
    return gl && new GlPainter(gl, points, count);
  }

  recolor(colors: Uint8Array): void {
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.table);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, TABLE, TABLE, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
  }

  draw(frame: Frame, paint: Paint): void {
    this.render(frame, PAINTS.indexOf(paint));
  }

  /** Draws a small picture of the regions. */
  seen(whole: Frame): Seen {
    const gl = this.gl;
    const width = Math.max(1, Math.round(whole.width / 2));
    const height = Math.max(1, Math.round(whole.height / 2));
    const count = Math.min(this.count, MOST_PICKED);
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
    this.render({ ...whole, width, height, count }, PICK);
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frame);
    gl.deleteRenderbuffer(color);
    gl.deleteRenderbuffer(depth);
    const at = (x: number, y: number): number => {
      const p = 4 * ((height - 1 - y) * width + x);
      // Blue tells a point from the background.
      return pixels[p + 2] === 255 ? pixels[p]! + 256 * pixels[p + 1]! : NONE;
    };
    return { width, height, at };
  }

  private render({ count, width, height, size, matrix }: Frame, paint: number): void {
    const gl = this.gl;
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.program);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.07, 0.08, 0.09, paint === PICK ? 0 : 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const at = (name: string): WebGLUniformLocation | null => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix4fv(at("view"), false, matrix);
    gl.uniform1f(at("size"), size);
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
