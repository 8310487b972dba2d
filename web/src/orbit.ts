// A camera that turns around a point: by pointer, touch, wheel and keys.

export type Matrix = Float32Array;

const [YAW, PITCH, DISTANCE] = [0.2, 0.2, 1.4]; // at first
const LEAST = 0.02;
const MOST = 40;
const VIEW = 0.9; // vertical angle, radians
const STEP = 0.12; // of a key, radians

export class Orbit {
  yaw = YAW;
  pitch = PITCH;
  distance = DISTANCE;
  target: [number, number, number] = [0, 0, 0];
  private readonly pointers = new Map<number, PointerEvent>();
  private readonly listeners: (() => void)[] = [];

  onChange(tell: () => void): void {
    this.listeners.push(tell);
  }

  listen(element: HTMLElement): void {
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
    });
    for (const end of ["pointerup", "pointercancel"] as const) {
      element.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    }
    element.addEventListener("pointermove", (event) => this.move(event, element.clientHeight));
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.zoom(Math.exp(event.deltaY * 0.001));
      },
      { passive: false },
    );
    element.addEventListener("keydown", (event) => {
      if (this.key(event.key, event.shiftKey)) event.preventDefault();
    });
  }

  get isHeld(): boolean {
    return this.pointers.size > 0;
  }

  zoom(factor: number): void {
    this.distance = Math.max(LEAST, Math.min(MOST, this.distance * factor));
    this.changed();
  }

  turn(yaw: number, pitch: number): void {
    this.yaw += yaw;
    this.pitch = Math.max(-1.55, Math.min(1.55, this.pitch + pitch));
    this.changed();
  }

  pan(x: number, y: number): void {
    const [right, up] = this.axes();
    for (let c = 0; c < 3; c++) {
      this.target[c]! -= this.distance * VIEW * (right[c]! * x - up[c]! * y);
    }
    this.changed();
  }

  reset(): void {
    this.yaw = YAW;
    this.pitch = PITCH;
    this.distance = DISTANCE;
    this.target = [0, 0, 0];
    this.changed();
  }

  /** From the scene to clip space, column by column. */
  matrix(aspect: number): Matrix {
    const [right, up, back] = this.axes();
    const eye = this.target.map((t, c) => t + back[c]! * this.distance);
    const shift = (axis: number[]): number => -axis.reduce((sum, v, c) => sum + v * eye[c]!, 0);
    const f = 1 / Math.tan(VIEW / 2);
    const [near, far] = [this.distance * 0.02, this.distance + 20];
    const [a, b] = [(far + near) / (near - far), (2 * far * near) / (near - far)];
    const wide = f / Math.max(aspect, 0.01);
    const tall = Math.min(1, aspect) * f; // a narrow screen sees as much of the width
    const x = aspect < 1 ? wide * aspect : wide;
    const rows = [right, up, back];
    const moved = rows.map(shift);
    const out = new Float32Array(16);
    for (let c = 0; c < 3; c++) {
      out[4 * c] = x * right[c]!;
      out[4 * c + 1] = tall * up[c]!;
      out[4 * c + 2] = a * back[c]!;
      out[4 * c + 3] = -back[c]!;
    }
    out[12] = x * moved[0]!;
    out[13] = tall * moved[1]!;
    out[14] = a * moved[2]! + b;
    out[15] = -moved[2]!;
    return out;
  }

  private axes(): [number[], number[], number[]] {
    const [sy, cy, sp, cp] = [
      Math.sin(this.yaw),
      Math.cos(this.yaw),
      Math.sin(this.pitch),
      Math.cos(this.pitch),
    ];
    return [
      [cy, 0, -sy],
      [-sy * sp, cp, -cy * sp],
      [sy * cp, sp, cy * cp],
    ];
  }

  private key(key: string, shift: boolean): boolean {
    const arrows: Record<string, [number, number]> = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, -1],
      ArrowDown: [0, 1],
    };
    const arrow = arrows[key];
    if (arrow && shift) this.pan(arrow[0] * 0.05, arrow[1] * 0.05);
    else if (arrow) this.turn(arrow[0] * STEP, arrow[1] * STEP);
    else if (key === "+" || key === "=") this.zoom(0.85);
    else if (key === "-") this.zoom(1 / 0.85);
    else if (key === "Home" || key === "0") this.reset();
    else return false;
    return true;
  }

  private move(event: PointerEvent, height: number): void {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last.clientX, event.clientY - last.clientY];
    const two = this.pointers.size === 2;
    if (two) {
      const other = [...this.pointers.values()].find((p) => p.pointerId !== event.pointerId)!;
      const apart = (p: PointerEvent): number =>
        Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
      this.zoom(Math.max(apart(last), 1) / Math.max(apart(event), 1));
    }
    this.pointers.set(event.pointerId, event);
    if (two || event.shiftKey || event.buttons & 2) this.pan(dx / height / (two ? 2 : 1), dy / height / (two ? 2 : 1));
    else this.turn((-dx / height) * 4, (dy / height) * 4);
  }

  private changed(): void {
    for (const tell of this.listeners) tell();
  }
}
