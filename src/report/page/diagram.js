'use strict';
// Evaluates decision diagrams. A node has three numbers: its level, and the arcs for true and for false. Node n + 2
// is at position n. An arc is the number of a node, negative if complemented; 1 is the terminal.

/** A diagram over `width` bits. */
function Diagram(nodes, width) {
  const node = Int32Array.from(nodes);

  /** Returns whether some assignment that matches the pattern (per level 0, 1, or 2 for any) satisfies it. */
  function meets(edge, pattern) {
    for (;;) {
      const id = Math.abs(edge);
      if (id === 1) return edge > 0;
      const at = 3 * (id - 2);
      const bit = pattern[node[at]];
      if (bit === 2) return search(edge, pattern);
      const next = node[at + (bit ? 1 : 2)];
      edge = edge > 0 ? next : -next;
    }
  }

  // The search that last visited an arc: searches are numbered, so that nothing needs to be cleared.
  const seen = new Int32Array(2 * (nodes.length / 3 + 2));
  let number = 0;

  function search(from, pattern) {
    const stack = [from];
    number += 1;
    while (stack.length) {
      const edge = stack.pop();
      const id = Math.abs(edge);
      if (id === 1) {
        if (edge > 0) return true;
        continue;
      }
      const place = 2 * id - (edge > 0 ? 3 : 4);
      if (seen[place] === number) continue;
      seen[place] = number;
      const at = 3 * (id - 2);
      const sign = Math.sign(edge);
      const bit = pattern[node[at]];
      if (bit !== 1) stack.push(sign * node[at + 2]);
      if (bit !== 0) stack.push(sign * node[at + 1]);
    }
    return false;
  }

  /** Returns the pattern of a view: one value per variable, null for any value. */
  function pattern(variables, view) {
    const bits = new Uint8Array(width).fill(2);
    variables.forEach((variable, index) => {
      const value = view[index];
      if (value === null) return;
      const offset = value - variable.low;
      // Shifts would cut values at 32 bits.
      variable.levels.forEach((level, k) => { bits[level] = Math.floor(offset / 2 ** k) % 2; });
    });
    return bits;
  }

  return { meets, pattern };
}
