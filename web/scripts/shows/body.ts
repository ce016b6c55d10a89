// A closed, bumpy trunk of so many triangles as a binary PLY in metres: as large on the screen as a scan, and as uneven.

const HALF = { across: 0.2, up: 0.3, deep: 0.12 }; // metres

export function bodyOf(triangles: number): Buffer {
  const rows = Math.round(Math.sqrt(triangles / 4));
  const around = Math.round(triangles / (2 * rows));
  const vertices = Buffer.alloc(12 * (rows + 1) * around);
  for (let row = 0; row <= rows; row += 1) {
    for (let step = 0; step < around; step += 1) {
      const [tilt, turn] = [Math.PI * (0.04 + 0.92 * (row / rows)), (2 * Math.PI * step) / around];
      const bump = 1 + 0.01 * Math.sin(40 * tilt) * Math.sin(37 * turn) + 0.003 * Math.sin(331 * tilt + 173 * turn);
      const breast = 0.25 * Math.exp(-((((tilt - 1.4) / 0.28) ** 2) + ((Math.abs(Math.atan2(Math.sin(turn - Math.PI / 2), Math.cos(turn - Math.PI / 2))) - 0.5) / 0.3) ** 2));
      const at = 12 * (row * around + step);
      vertices.writeFloatLE(HALF.across * Math.sin(tilt) ** 0.5 * Math.cos(turn) * bump, at);
      vertices.writeFloatLE(HALF.up * Math.cos(tilt) * bump, at + 4);
      vertices.writeFloatLE(HALF.deep * Math.sin(tilt) ** 0.5 * Math.sin(turn) * (bump + breast), at + 8);
    }
  }
  const faces = Buffer.alloc(13 * 2 * rows * around);
  let at = 0;
  const write = (corners: readonly number[]): void => {
    faces.writeUInt8(3, at);
    corners.forEach((corner, i) => faces.writeInt32LE(corner, at + 1 + 4 * i));
    at += 13;
  };
  for (let row = 0; row < rows; row += 1) {
    for (let step = 0; step < around; step += 1) {
      const [a, b] = [row * around + step, row * around + ((step + 1) % around)];
      write([a, b, a + around]);
      write([b, b + around, a + around]);
    }
  }
  const head = ["ply", "format binary_little_endian 1.0", `element vertex ${(rows + 1) * around}`, "property float x", "property float y", "property float z", `element face ${2 * rows * around}`, "property list uchar int vertex_indices", "end_header", ""];
  return Buffer.concat([Buffer.from(head.join("\n")), vertices, faces]);
}
