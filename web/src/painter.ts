// What draws points: the graphics processor, or, without one, the main processor.

export type Paint = "segment" | "color" | "depth" | "normals";

export const PAINTS: Paint[] = ["segment", "color", "depth", "normals"];
export const NONE = 65535;
export const TABLE = 256; // side of the table with a colour for each region

export interface Frame {
  count: number; // of points to draw, the first ones
  width: number;
  height: number;
  size: number; // of a point, pixels
  matrix: Float32Array;
}

/** The region at each pixel of a picture, from the top left. */
export interface Seen {
  width: number;
  height: number;
  at(x: number, y: number): number;
}

export interface Painter {
  /** Takes a new colour, red, green, blue and 0 for hidden, for each region. */
  recolor(colors: Uint8Array): void;
  draw(frame: Frame, paint: Paint): void;
  seen(whole: Frame): Seen;
}
