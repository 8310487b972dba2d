// What dropped files are: roles, told by names and the first bytes; and frames of a folder.

export type Files = Map<string, File>;

export interface Frame {
  name: string;
  files: Files;
}

const CLOUDS = /\.(ply|pcd|las|laz|e57|xyz|xyzrgb|asc|pts)$/i;
const IMAGES = /\.(png|jpe?g|ppm|bmp|tiff?|webp)$/i;
const MAPS = /\.(pgm|npy|npz|pfm|exr)$/i;
const TEXTS = /\.(txt|json|ya?ml|xml|cal|ini|csv)$/i;

const DISPARITY = /disp/i;
const DEPTH = /depth|(^|[_./-])(d|range|z|tof)([_.-]|\d|$)/i;
const RIGHT = /right|(^|[_./-])(im1|r|image_?0?[13]|view5)([_./]|$)/i;

/** The path of a file within what was opened, its name if there is none. */
function path(file: File): string {
  return file.webkitRelativePath || file.name;
}

/** Whether a PNG has one channel of 16 bits, as depth maps have. */
async function isDeep(file: File): Promise<boolean> {
  const head = new DataView(await file.slice(0, 26).arrayBuffer());
  return head.byteLength === 26 && head.getUint32(0) === 0x89504e47 && head.getUint8(24) === 16 && head.getUint8(25) === 0;
}

async function roleOf(file: File): Promise<string | null> {
  const name = path(file);
  if (CLOUDS.test(name)) return "cloud";
  if (MAPS.test(name)) return DISPARITY.test(name) ? "disparity" : "depth";
  if (TEXTS.test(name)) return "camera";
  if (!IMAGES.test(name)) return null;
  if (DISPARITY.test(name)) return "disparity";
  if (DEPTH.test(name) || (await isDeep(file))) return "depth";
  return RIGHT.test(name) ? "right" : "color";
}

/** Sorts files into the frames of a folder, or the one scene that they are. */
export async function framesOf(files: File[]): Promise<Frame[]> {
  const sorted = [...files].sort((a, b) => path(a).localeCompare(path(b), "en", { numeric: true }));
  const by = new Map<string, File[]>();
  for (const file of sorted) {
    const role = await roleOf(file);
    if (role) by.set(role, [...(by.get(role) ?? []), file]);
  }
  const of = (role: string): File[] => by.get(role) ?? [];
  const arrays = of("depth").filter((file) => /\.np[yz]$/i.test(file.name));
  if (!of("color").length && !of("right").length && arrays.length) by.set("cloud", [...of("cloud"), ...arrays]);
  const clouds = of("cloud").map((file) => ({ name: path(file), files: new Map([["cloud", file]]) }));
  const colors = of("color");
  // Two pictures that nothing tells apart are a stereo pair.
  if (colors.length === 2 && !of("right").length && !of("depth").length) by.set("right", colors.splice(1));
  return [...colors.map((color, i) => withOthers(color, i, colors.length, of)), ...clouds];
}

function withOthers(color: File, i: number, n: number, of: (role: string) => File[]): Frame {
  const files: Files = new Map([["color", color]]);
  for (const role of ["right", "disparity", "depth"]) {
    const found = partner(color, i, n, of(role));
    if (found) files.set(role, found);
  }
  if (files.has("right")) files.delete("depth");
  else if (files.has("disparity")) {
    // A disparity map without a right image cannot be used.
    files.delete("disparity");
  }
  const camera = of("camera")[0];
  if (camera && files.has("right")) files.set("calib", camera);
  else if (camera && files.has("depth") && !/\.csv$/i.test(camera.name)) files.set("intrinsics", camera);
  return { name: path(color), files };
}

/** The file that goes with a picture: in the same place of as long a list, or of the same number. */
function partner(color: File, i: number, n: number, others: File[]): File | undefined {
  if (others.length === n) return others[i];
  const number = (file: File): string => /(\d+)\D*$/.exec(file.name)?.[1] ?? file.name;
  return others.find((other) => number(other) === number(color));
}
