// The tree of merges: the segments of any level, and what a segment falls into.

import type { View } from "./api";

export type Tree = Pick<View, "n_regions" | "merges" | "heights" | "size">;

/** The cluster of each region after the first merges, named by one of its regions. */
export function rootsAfter(tree: Tree, merges: number): Int32Array {
  const root = Int32Array.from({ length: tree.n_regions }, (_, i) => i);
  // Later merges are followed first, so each name already leads to the last one.
  for (let m = merges - 1; m >= 0; m--) {
    const [kept, gone] = tree.merges[m]!;
    root[gone] = root[kept]!;
  }
  return root;
}

/**
 * A number for each region such that the level with K segments has the numbers 0 to K - 1 where a
 * segment has the least number among its regions. A segment that splits keeps its number, and so
 * its colour, in the larger part.
 */
export function numbers(tree: Tree): Int32Array {
  const root = rootsAfter(tree, tree.merges.length);
  const size = new Float64Array(tree.n_regions);
  for (let r = 0; r < tree.n_regions; r++) size[r] = tree.size[r]!;
  const steps = tree.merges.map(([kept, gone]) => {
    const larger = size[kept]! >= size[gone]!;
    size[kept]! += size[gone]!;
    return larger;
  });
  const last = [...new Set(root)].sort((a, b) => size[b]! - size[a]! || a - b);
  const number = new Int32Array(tree.n_regions);
  last.forEach((r, i) => (number[r] = i));
  let next = last.length;
  for (let m = tree.merges.length - 1; m >= 0; m--) {
    const [kept, gone] = tree.merges[m]!;
    if (steps[m]) number[gone] = next++;
    else {
      number[gone] = number[kept]!;
      number[kept] = next++;
    }
  }
  return number;
}

/** The least number among the regions of each cluster, for each region. */
export function named(cluster: Int32Array, number: Int32Array): Int32Array {
  const least = new Map<number, number>();
  cluster.forEach((c, r) => {
    const known = least.get(c);
    if (known === undefined || number[r]! < known) least.set(c, number[r]!);
  });
  return cluster.map((c) => least.get(c)!);
}

/** After how many merges the segments of a degree of detail appear. */
export function mergesAt(tree: Tree, detail: number): number {
  let low = 0;
  let high = tree.heights.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (tree.heights[middle]! < -detail) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The two parts, or the pieces, that some regions fall into along the next level of the tree. */
export function parts(tree: Tree, members: number[]): number[][] {
  const within = new Set(members);
  const at = Int32Array.from({ length: tree.n_regions }, (_, i) => (within.has(i) ? i : -1));
  const joined: [number, number][] = [];
  for (const [kept, gone] of tree.merges) {
    if (at[kept]! >= 0 && at[gone]! >= 0) joined.push([at[kept]!, at[gone]!]);
    else if (at[gone]! >= 0) at[kept] = at[gone]!;
  }
  // Pieces that a person joined, and the tree never does, come apart first.
  if (joined.length === members.length - 1) joined.pop();
  const root = new Map(members.map((r) => [r, r]));
  for (const [kept, gone] of joined.reverse()) root.set(gone, root.get(kept)!);
  const found = new Map<number, number[]>();
  for (const r of members) {
    const name = root.get(r)!;
    const list = found.get(name);
    if (list) list.push(r);
    else found.set(name, [r]);
  }
  return [...found.values()];
}

/** For each pair of regions the height of the merge at which they become one; infinite if none. */
export function heightsOf(tree: Tree, pairs: [number, number][]): Float64Array {
  const n = tree.n_regions;
  const parent = new Int32Array(n + tree.merges.length).fill(-1);
  const node = Int32Array.from({ length: n }, (_, i) => i);
  tree.merges.forEach(([kept, gone], m) => {
    parent[node[kept]!] = parent[node[gone]!] = n + m;
    node[kept] = n + m;
  });
  return Float64Array.from(pairs, ([one, other]) => {
    let [a, b] = [one, other];
    while (a !== b) {
      if (a < b) a = parent[a]!;
      else b = parent[b]!;
      if (a < 0 || b < 0) return Infinity;
    }
    return tree.heights[a - n]!;
  });
}
