// Which scan files the page decodes itself, before they are sent: compressed or nested ones.  Their decoders are large and
// eat hostile bytes, so they run in a worker of the browser, and the service is given plain triangles.
const GLB_HEAD = 20; // bytes: magic, version, length, and the head of the first chunk
const MOST_JSON = 16 * 2 ** 20; // more than the service reads
const COMPRESSIONS = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_texture_webp", "EXT_texture_avif"];

export type ContainerKind = "glb" | "usd";

/** Null for a file that is sent as it is. */
export async function containerKind(file: File): Promise<ContainerKind | null> {
  if (/\.(usdz|usd|usda|usdc)$/i.test(file.name)) return "usd";
  if (!/\.glb$/i.test(file.name) || file.size < GLB_HEAD) return null;
  const head = new DataView(await file.slice(0, GLB_HEAD).arrayBuffer());
  const length = head.getUint32(12, true);
  if (length > MOST_JSON) return null;
  const description = await file.slice(GLB_HEAD, GLB_HEAD + length).text();
  return COMPRESSIONS.some((name) => description.includes(`"${name}"`)) ? "glb" : null;
}
