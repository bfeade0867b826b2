// The walls of the map at every zoom. When a picture is made smaller, it usually loses thin walls. Here each step halves
// the size, and a cell is a wall if any of the four cells that it replaces is a wall.
const BOUNDED = 64; // length, in cells, of the longer side of the picture in which the bounds are searched

export class Walls {
  // image: one pixel for each cell; [x, y, width, height]: its place in m.
  constructor(image, [x, y, width, height]) {
    this.x = x; this.top = y + height;
    this.cell = width / image.naturalWidth; // m
    let level = pixelsOf(image);
    this.levels = [pictureOf(level)];
    for (this.bounds = undefined; this.bounds === undefined || Math.max(level.wide, level.tall) > 2;) {
      if (this.bounds === undefined && Math.max(level.wide, level.tall) <= BOUNDED) this.bounds = this.boundsOf(level);
      level = halfOf(level);
      this.levels.push(pictureOf(level));
    }
  }

  // pixel: from m to px; ratio: pixels of the screen per px.
  draw(paint, pixel, scale, ratio) {
    const wanted = Math.ceil(Math.log2(1 / (this.cell * scale * ratio)));
    const level = Math.max(0, Math.min(this.levels.length - 1, wanted)), picture = this.levels[level];
    const size = this.cell * 2 ** level * scale, [left, top] = pixel(this.x, this.top);
    paint.imageSmoothingEnabled = false;
    paint.drawImage(picture, left, top, picture.width * size, picture.height * size);
  }

  // Returns the smallest rectangle that contains all walls, in m: [left, low, right, high]; null: there are no walls.
  boundsOf({ cells, wide }) {
    const size = this.cell * 2 ** (this.levels.length - 1);
    let [left, top, right, bottom] = [Infinity, Infinity, -1, -1];
    cells.forEach((cell, k) => {
      if (!cell) return;
      const x = k % wide, y = Math.floor(k / wide);
      left = Math.min(left, x); right = Math.max(right, x); top = Math.min(top, y); bottom = Math.max(bottom, y);
    });
    return right < 0 ? null : [this.x + left * size, this.top - (bottom + 1) * size, this.x + (right + 1) * size, this.top - top * size];
  }
}

function pixelsOf(image) {
  const wide = image.naturalWidth, tall = image.naturalHeight, paint = surface(wide, tall);
  paint.drawImage(image, 0, 0);
  return { cells: new Uint32Array(paint.getImageData(0, 0, wide, tall).data.buffer), wide, tall };
}

function halfOf({ cells, wide, tall }) {
  const half = { wide: Math.ceil(wide / 2), tall: Math.ceil(tall / 2) };
  half.cells = new Uint32Array(half.wide * half.tall);
  for (let y = 0, k = 0; y < tall; y += 1) {
    const row = (y >> 1) * half.wide;
    for (let x = 0; x < wide; x += 1, k += 1) if (cells[k]) half.cells[row + (x >> 1)] = cells[k];
  }
  return half;
}

function pictureOf({ cells, wide, tall }) {
  const paint = surface(wide, tall);
  paint.putImageData(new ImageData(new Uint8ClampedArray(cells.buffer), wide, tall), 0, 0);
  return paint.canvas;
}

function surface(width, height) {
  const canvas = document.createElement('canvas');
  canvas.width = width; canvas.height = height;
  return canvas.getContext('2d');
}
