// The quality Q over the weight, with the weight that was chosen and the one that is shown.

const SVG = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT, LEFT, BOTTOM] = [300, 130, 34, 22];

function make(name: string, attributes: Record<string, string | number>, text = ""): SVGElement {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.textContent = text;
  return element;
}

/** Draws the curve into a box; `chosen` and `now` are weights. */
export function drawCurve(box: HTMLElement, curve: [number, number][], chosen: number, now: number): void {
  const known = curve.filter(([w, q]) => Number.isFinite(w) && Number.isFinite(q));
  const logs = known.map(([w]) => Math.log10(Math.max(w, 1e-3)));
  const [low, high] = [Math.min(...logs), Math.max(...logs)];
  const qs = known.map(([, q]) => q);
  const [least, most] = [Math.min(...qs), Math.max(...qs)];
  const x = (w: number): number =>
    LEFT + ((Math.log10(Math.max(w, 1e-3)) - low) / Math.max(high - low, 1e-9)) * (WIDTH - LEFT - 8);
  const y = (q: number): number =>
    8 + ((most - q) / Math.max(most - least, 1e-9)) * (HEIGHT - BOTTOM - 16);
  const at = (w: number): number => known.find(([v]) => v === w)?.[1] ?? most;
  const line = known.map(([w, q], i) => `${i ? "L" : "M"}${x(w).toFixed(1)},${y(q).toFixed(1)}`).join("");
  const label = `Quality from ${least.toFixed(3)} to ${most.toFixed(3)}, highest at weight ${chosen.toPrecision(3)}`;
  const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label });
  svg.append(
    make("path", { class: "axis", d: `M${LEFT},4V${HEIGHT - BOTTOM}H${WIDTH - 4}` }),
    make("path", { class: "q", d: line }),
    make("circle", { class: "chosen", cx: x(chosen), cy: y(at(chosen)), r: 4.5 }),
    make("circle", { class: "now", cx: x(now), cy: y(at(now)), r: 7 }),
    make("text", { x: 2, y: 14 }, most.toFixed(2)),
    make("text", { x: 2, y: HEIGHT - BOTTOM - 4 }, least.toFixed(2)),
    make("text", { x: LEFT, y: HEIGHT - 6 }, (10 ** low).toPrecision(2)),
    make("text", { x: WIDTH - 6, y: HEIGHT - 6, "text-anchor": "end" }, (10 ** high).toPrecision(2)),
  );
  box.replaceChildren(svg);
}
