// A file that was built with the page, as bytes.

export async function assetBytes(address: string): Promise<ArrayBuffer> {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${answer.status} for a file of the page`);
  return answer.arrayBuffer();
}
