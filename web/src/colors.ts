// Colours of segments, depths and shares.

export type Color = readonly [number, number, number];

// Okabe and Ito (2008) without black, then Tol's muted scheme: safe for colour-blind readers.
const SAFE = (
  "0072B2 E69F00 009E73 CC79A7 56B4E9 D55E00 F0E442 " +
  "332288 88CCEE 117733 999933 DDCC77 CC6677 882255 AA4499"
).split(" ");

const mix = (a: number, b: number, t: number): number => Math.round(a * (1 - t) + b * t);

function safe(segment: number): Color {
  const code = parseInt(SAFE[segment % SAFE.length]!, 16);
  const turn = Math.floor(segment / SAFE.length) % 3;
  const [share, target] = [[0, 0], [0.4, 0], [0.5, 255]][turn]! as [number, number];
  return [mix(code >> 16, target, share), mix((code >> 8) & 255, target, share), mix(code & 255, target, share)];
}

// Hues a golden angle apart, in turns of three lightnesses.
function vivid(segment: number): Color {
  const hue = (segment * 137.508) % 360;
  const light = [0.52, 0.68, 0.36][segment % 3]!;
  const spread = 0.75 * Math.min(light, 1 - light);
  const part = (n: number): number => {
    const k = (n + hue / 30) % 12;
    return Math.round(255 * (light - spread * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
  };
  return [part(0), part(8), part(4)];
}

export function colorOf(segment: number, forAll: boolean): Color {
  return forAll ? safe(segment) : vivid(segment);
}

// Samples of viridis, readable without colour vision, too.
const RAMP: Color[] = [
  [68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142],
  [31, 158, 137], [53, 183, 121], [109, 205, 89], [180, 222, 44], [253, 231, 37],
];

/** The colour of a share from 0 to 1. */
export function ramp(share: number): Color {
  const at = Math.max(0, Math.min(1, share)) * (RAMP.length - 1);
  const low = Math.min(Math.floor(at), RAMP.length - 2);
  const [a, b, t] = [RAMP[low]!, RAMP[low + 1]!, at - low];
  return [mix(a[0], b[0], t), mix(a[1], b[1], t), mix(a[2], b[2], t)];
}

export function hex([r, g, b]: Color): string {
  return "#" + [r, g, b].map((v) => Math.round(v).toString(16).padStart(2, "0")).join("");
}
