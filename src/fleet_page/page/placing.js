// Finds places for texts beside their points, so that no text covers another.
//
// A text gets the first of its places that is free, as in rviz_drawing, which places the texts of RViz and of the
// editor. If no place is free, `text.may` says what the text may cover: soft boxes, or all boxes. The text then gets
// the place where it covers least.
export const ABOVE_FIRST = [[0, -1], [0, 1], [1, 0], [-1, 0], [1, -1], [-1, -1], [1, 1], [-1, 1]];
export const BELOW_RIGHT_FIRST = [[1, 1], [-1, 1], [1, -1], [-1, -1], [0, 1], [0, -1], [1, 0], [-1, 0]];
const CELL = 64; // px of the grid in which neighbours are found

export class Places {
  constructor(width, height) {
    this.width = width; this.height = height;
    this.cells = new Map();
  }

  // Marks a box as covered: [left, top, right, bottom].
  cover(box, isSoft = false) {
    const covered = { box, isSoft };
    for (const key of cellsOf(box)) {
      if (!this.cells.has(key)) this.cells.set(key, []);
      this.cells.get(key).push(covered);
    }
  }

  // Returns the side of a text, as an index in `sides`; -1: there is no place for the text.
  // text: x, y of its point, distance `away` from the point, width, height, and `may`: what it may cover ('soft',
  // 'all'; without `may` nothing); before: the side where the text was.
  place(text, sides, before = -1) {
    const order = before < 0 ? sides.keys() : [before, ...[...sides.keys()].filter(side => side !== before)];
    let best = -1, least = { firm: Infinity, soft: Infinity };
    for (const side of order) {
      const covered = this.covered(boxOf(text, sides[side]));
      if (covered.firm < least.firm || (covered.firm === least.firm && covered.soft < least.soft)) { least = covered; best = side; }
      if (!covered.firm && !covered.soft) break;
    }
    if ((least.firm && text.may !== 'all') || (least.soft && !text.may)) return -1;
    this.cover(boxOf(text, sides[best]));
    return best;
  }

  // Returns how much of a box is covered (px²) by firm and by soft boxes. The part outside the window counts as firm.
  covered(box) {
    const size = (box[2] - box[0]) * (box[3] - box[1]);
    const sum = { firm: size - shared(box, [0, 0, this.width, this.height]), soft: 0 };
    const seen = new Set();
    for (const key of cellsOf(box)) {
      for (const other of this.cells.get(key) || []) {
        if (!seen.has(other)) { seen.add(other); sum[other.isSoft ? 'soft' : 'firm'] += shared(box, other.box); }
      }
    }
    return sum;
  }
}

export function boxOf({ x, y, away, width, height }, [right, down]) {
  const diagonal = right && down ? Math.SQRT1_2 : 1;
  const cx = x + right * (away * diagonal + width / 2), cy = y + down * (away * diagonal + height / 2);
  return [cx - width / 2, cy - height / 2, cx + width / 2, cy + height / 2];
}

function shared(one, other) {
  const wide = Math.min(one[2], other[2]) - Math.max(one[0], other[0]), tall = Math.min(one[3], other[3]) - Math.max(one[1], other[1]);
  return wide > 0 && tall > 0 ? wide * tall : 0;
}

function* cellsOf([left, top, right, bottom]) {
  for (let x = Math.floor(left / CELL); x <= Math.floor(right / CELL); x += 1) {
    for (let y = Math.floor(top / CELL); y <= Math.floor(bottom / CELL); y += 1) yield `${x} ${y}`;
  }
}
