// What a file may be, by its name and its first bytes: a guess of where to send it; what it is the service says.
/** An image, a label map or lesions alone, or packed into one. */
export const isVolume = (file: File): boolean => /\.(nii|nii\.gz|nrrd|nhdr|mha|mhd|dcm|zip)$|^[^.]*$/i.test(file.name);
const CLASSES = /1\.2\.840\.10008\.5\.1\.4\.1\.1\.(66\.[47]|481\.3)(?![\d.])/; // segmentations, structure sets
const HEAD = 2048; // bytes in which a DICOM file says what it is

/** What a DICOM file says of itself: slices of an image, or what was drawn on one. */
export async function dicomOf(file: File): Promise<"image" | "segments" | null> {
  const head = await file.slice(0, HEAD).arrayBuffer().then((bytes) => new TextDecoder("latin1").decode(bytes), () => "");
  return head.slice(128, 132) !== "DICM" ? null : CLASSES.test(head) ? "segments" : "image";
}
