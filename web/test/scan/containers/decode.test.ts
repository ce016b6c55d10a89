import { readFileSync } from "node:fs";
import { BufferAttribute, BufferGeometry, Mesh, MeshStandardMaterial, Scene } from "three";
import { USDZExporter } from "three/addons/exporters/USDZExporter.js";
import { unzipSync, zipSync } from "three/examples/jsm/libs/fflate.module.js";
import { expect, test, vi } from "vitest";
import { decodeGlb, type Tools } from "../../../src/scan/containers/decodeGlb";
import { decodeUsd } from "../../../src/scan/containers/decodeUsd";
import { openDraco } from "../../../src/scan/containers/draco";
import { openGlb, packGlb } from "../../../src/scan/containers/glb";
import { containerKind } from "../../../src/scan/containers/kind";
import * as text from "../../../src/scan/containers/text";
import { colour, CORNERS, dracoGlb, meshoptGlb, place, places, RINGS, SEGMENTS, triangles } from "./files";
import { read } from "./unpacked";

const WASM = "node_modules/three/examples/jsm/libs/draco/gltf/draco_decoder.wasm";
const PICTURE = Uint8Array.of(0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10, 1, 2, 3);
const tools: Tools = {
  draco: () => openDraco(new Uint8Array(readFileSync(WASM)).buffer),
  plainPicture: async (bytes) => ({ bytes: Uint8Array.of(0xff, 0xd8, bytes.length), kind: "image/jpeg" }),
};

/** Ring and segment of a vertex, by its place. */
function whose([x, y, z]: number[], scale = 1): [number, number] {
  const angle = Math.atan2(z!, x!) / (2 * Math.PI);
  return [Math.round(y! / scale / 0.05), ((Math.round(angle * SEGMENTS) % SEGMENTS) + SEGMENTS) % SEGMENTS];
}

/** Each triangle as the places of its corners, sorted: decoders may renumber and turn. */
const shape = (position: number[][], indices: number[]): string[] =>
  Array.from({ length: indices.length / 3 }, (_, face) => [0, 1, 2].map((corner) => whose(position[indices[3 * face + corner]!]!).join(":")).sort().join(" ")).sort();

const wanted = (): string[] => {
  const flat = places();
  return shape(Array.from({ length: flat.length / 3 }, (_, index) => flat.slice(3 * index, 3 * index + 3)), triangles());
};

test("a GLB that Draco compressed becomes the same triangles, places, colours and coordinates as plain arrays", async () => {
  const { document, parts } = read(await decodeGlb(dracoGlb(), tools));
  const [part] = parts;
  expect(part!.indices).toHaveLength(CORNERS);
  expect(shape(part!.position, part!.indices)).toEqual(wanted());
  part!.position.forEach((found, index) => {
    const [ring, segment] = whose(found);
    place(ring, segment).forEach((number, axis) => expect(found[axis]).toBeCloseTo(number, 3));
    expect(part!.colour![index]!.map((share) => Math.round(255 * share))).toEqual(colour(ring, segment));
    expect(part!.uv![index]![0]).toBeCloseTo(segment / SEGMENTS, 3);
    expect(part!.uv![index]![1]).toBeCloseTo(ring / RINGS, 3);
  });
  expect(document.extensionsUsed).toEqual([]);
  expect(document.extensionsRequired).toEqual([]);
  expect(document.nodes).toEqual([{ mesh: 0, scale: [2, 2, 2] }]);
  expect(JSON.stringify(document)).not.toContain("Mustermann");
});

test("a GLB that meshopt compressed becomes the same to the last bit", async () => {
  const [part] = read(await decodeGlb(meshoptGlb(), tools)).parts;
  expect(shape(part!.position, part!.indices)).toEqual(wanted());
  part!.position.forEach((found, index) => {
    const [ring, segment] = whose(found);
    expect(found).toEqual(place(ring, segment).map(Math.fround));
    expect(part!.colour![index]!.map((share) => 255 * share)).toEqual([...colour(ring, segment), 255]);
  });
});

test("pictures of newer kinds are decoded by the browser, and all others stay byte for byte", async () => {
  const { document, binary } = openGlb(meshoptGlb());
  const whole = new Uint8Array(binary.length + 11);
  whole.set(binary);
  whole.set(PICTURE, binary.length);
  const view = { buffer: 0, byteOffset: binary.length, byteLength: PICTURE.length };
  const first = document.bufferViews!.length;
  const changed = {
    ...document,
    bufferViews: [...document.bufferViews!, view, view],
    images: [{ mimeType: "image/png", bufferView: first }, { mimeType: "image/webp", bufferView: first + 1, name: "Mustermann" }],
    textures: [{ source: 0 }, { extensions: { EXT_texture_webp: { source: 1 } } }],
    extensionsRequired: ["EXT_meshopt_compression", "EXT_texture_webp"],
  };
  const plain = read(await decodeGlb(packGlb(changed, whole), tools));
  expect(plain.pictures).toEqual([PICTURE, Uint8Array.of(0xff, 0xd8, 11)]);
  expect(plain.document.textures).toEqual([{ source: 0 }, { source: 1, extensions: {} }]);
  expect(plain.document.extensionsRequired).toEqual([]);
  expect(JSON.stringify(plain.document)).not.toContain("Mustermann");
});

function tube(): Mesh<BufferGeometry, MeshStandardMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(places()), 3));
  geometry.setIndex(triangles());
  geometry.computeVertexNormals();
  return new Mesh(geometry, new MeshStandardMaterial());
}

test("a USDZ becomes plain triangles where its scene puts them", async () => {
  const mesh = tube();
  mesh.position.set(0, 0.5, 0);
  const scene = new Scene().add(mesh);
  scene.updateMatrixWorld(true);
  const usdz = await new USDZExporter().parseAsync(scene);
  const [part] = read(await decodeUsd(new Uint8Array(usdz))).parts;
  const back = part!.position.map(([x, y, z]) => [x!, y! - 0.5, z!]);
  expect(shape(back, part!.indices)).toEqual(wanted());
});

const LAYER = (more: string, head = ""): string => `#usda 1.0
(
    defaultPrim = "Root"
    ${head}
)
def Xform "Root"
{
    def Mesh "Mustermann"
    {
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 0, 3, 4]
        point3f[] points = [(0, 0, 0), (100, 0, 0), (100, 0, 50), (0, 0, 50), (-50, 0, 50)]
        ${more}
    }
}
`;
const PAINTED = `texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.25)] (
            interpolation = "vertex"
        )
        rel material:binding = </Root/Skin>
    }
    def Material "Skin"
    {
        token outputs:surface.connect = </Root/Skin/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </Root/Skin/Map.outputs:rgb>
            token outputs:surface
        }
        def Shader "Map"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @PICTURE@
            float2 inputs:st.connect = </Root/Skin/Reader.outputs:result>
            color3f outputs:rgb
        }
        def Shader "Reader"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }`;
const packed = (layer: string): Uint8Array => zipSync({ "scan.usda": new TextEncoder().encode(layer), "0/skin.png": PICTURE, "thumbnail.jpg": Uint8Array.of(1) }, { level: 0 });

test("axis and unit of a USD are followed, polygons become triangles, the picture keeps its bytes and nothing keeps its name", async () => {
  const glb = await decodeUsd(packed(LAYER(PAINTED.replace("PICTURE", "0/skin.png"), 'upAxis = "Z"\n    metersPerUnit = 0.01')));
  const { document, parts, pictures } = read(glb);
  const corners = parts.flatMap(({ indices, position, uv }) => indices.map((index) => [position[index]!, uv![index]!] as const));
  expect(corners).toHaveLength(9);
  for (const [[x, y, z], [u, v]] of corners) {
    const found = [[0, 0], [1, 0], [1, 0.5], [0, 0.5], [-0.5, 0.5]].findIndex(([wantedX, wantedY]) => Math.hypot(wantedX! - x!, wantedY! - y!, z!) < 1e-6);
    expect([u, v!]).toEqual([[0, 1], [1, 1], [1, 0], [0, 0], [0.5, 0.75]][found]);
  }
  expect(pictures).toEqual([PICTURE]);
  expect(JSON.stringify(document)).not.toMatch(/Mustermann|skin/);
});

test("no address that a USD names is asked for, whatever it is", async () => {
  const asked = vi.fn();
  vi.spyOn(console, "warn").mockImplementation(() => undefined); // three.js names the picture that it does not find
  vi.stubGlobal("fetch", asked);
  vi.stubGlobal("XMLHttpRequest", asked);
  for (const address of ["https://example.org/a.png", "../../secret.png", "picture:0/other.png", "/etc/passwd"]) {
    expect(read(await decodeUsd(packed(LAYER(PAINTED.replace("PICTURE", address))))).pictures).toEqual([]);
  }
  await decodeUsd(packed(LAYER("").replace('def Xform "Root"', 'def Xform "Root" (\n    references = @https://example.org/body.usda@\n)')));
  expect(asked).not.toHaveBeenCalled();
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

const cut = (bytes: Uint8Array, share: number): Uint8Array => bytes.slice(0, Math.floor(share * bytes.length));

test.each([0.2, 0.5, 0.8, 0.97])("a file cut off after %f of its bytes is one refusal, never a mesh of half a body", async (share) => {
  const usdz = await new USDZExporter().parseAsync(new Scene().add(tube()));
  await expect(decodeGlb(cut(dracoGlb(), share), tools)).rejects.toThrow();
  await expect(decodeGlb(cut(meshoptGlb(), share), tools)).rejects.toThrow();
  await expect(decodeUsd(cut(new Uint8Array(usdz), share))).rejects.toThrow();
});

test("a file that asks for much in few bytes is refused before it is unpacked", async () => {
  const { document, binary } = openGlb(meshoptGlb());
  const large = structuredClone(document);
  large.bufferViews![0]!.extensions!.EXT_meshopt_compression!.count = 40_000_000;
  await expect(decodeGlb(packGlb(large, binary), tools)).rejects.toThrow(text.unpacksTooLarge(400));
  const many = structuredClone(document);
  many.accessors![2]!.count = 16_000_000;
  await expect(decodeGlb(packGlb(many, binary), tools)).rejects.toThrow("2,000,000 triangles");
  const bomb = zipSync({ "scan.usda": new Uint8Array(1000) });
  const directory = bomb.findIndex((_, at) => new DataView(bomb.buffer).getUint32(at, true) === 0x02014b50);
  new DataView(bomb.buffer).setUint32(directory + 24, 500 * 2 ** 20, true);
  await expect(decodeUsd(bomb)).rejects.toThrow(text.unpacksTooLarge(400));
  expect(Object.keys(unzipSync(packed("")))).toHaveLength(3);
});

test("a file without triangles, and one that points elsewhere, are told apart", async () => {
  await expect(decodeUsd(new TextEncoder().encode("#usda 1.0\n"))).rejects.toThrow(text.noMesh);
  await expect(decodeUsd(zipSync({ "a.txt": PICTURE }))).rejects.toThrow(text.noMesh);
  const { document, binary } = openGlb(meshoptGlb());
  await expect(decodeGlb(packGlb({ ...document, images: [{ uri: "https://example.org/a.png" }] }, binary), tools)).rejects.toThrow(text.elsewhere);
});

test("only compressed GLBs and USD are unpacked in the page", async () => {
  const kind = (name: string, ...parts: BlobPart[]) => containerKind(new File(parts, name));
  const { document, binary } = openGlb(meshoptGlb());
  expect(await kind("scan.glb", dracoGlb())).toBe("glb");
  expect(await kind("Scan.GLB", meshoptGlb())).toBe("glb");
  expect(await kind("scan.glb", packGlb({ asset: document.asset, meshes: document.meshes }, binary))).toBeNull();
  expect(await kind("scan.glb", "no glb at all, but long enough to look like one")).toBeNull();
  expect(await kind("scan.USDZ", "PK")).toBe("usd");
  expect(await kind("scan.ply", dracoGlb())).toBeNull();
});

const FUZZ = Number(process.env.BREASTRIG_FUZZ ?? "0.5"); // as in the tests of the service: `make fuzz` tries more

test("damaged files are refused, or unpacked to a GLB that is whole", async () => {
  vi.spyOn(console, "warn").mockImplementation(() => undefined);
  vi.spyOn(console, "error").mockImplementation(() => undefined);
  const usdz = new Uint8Array(await new USDZExporter().parseAsync(new Scene().add(tube())));
  const files = [[dracoGlb(), (bytes: Uint8Array) => decodeGlb(bytes, tools)], [meshoptGlb(), (bytes: Uint8Array) => decodeGlb(bytes, tools)], [usdz, decodeUsd]] as const;
  const outcomes = { refused: 0, unpacked: 0 };
  const seed = FUZZ < 1 ? 1 : (Date.now() % 0x7ffffffe) + 1;
  let state = seed;
  const random = (below: number): number => Math.floor(((state = (state * 48271) % 0x7fffffff) / 0x7fffffff) * below);
  for (let round = 0; round < Math.round(80 * FUZZ); round += 1) {
    for (const [whole, decode] of files) {
      const bytes = whole.slice();
      for (let edit = 0; edit <= random(4); edit += 1) bytes[random(random(2) ? bytes.length : 600)] = random(256);
      const glb = await decode(bytes).catch(() => null);
      outcomes[glb ? "unpacked" : "refused"] += 1;
      if (glb) expect(new DataView(glb.buffer).getUint32(8, true), `seed ${seed}`).toBe(glb.length);
    }
  }
  expect(outcomes.refused).toBeGreaterThan(0);
  expect(outcomes.unpacked).toBeGreaterThan(0);
  vi.restoreAllMocks();
});
