// Sentences on files that the page decodes.

export const damaged = "This file is damaged, or compressed in a way that is not known here; export the scan again, as a plain GLB or PLY.";
export const noMesh = "This file holds no triangle mesh that can be read here; export the scan as GLB, PLY or OBJ.";
export const tooLarge = (triangles: string) => `This scan has more than the ${triangles} triangles allowed; simplify it first.`;
export const unpacksTooLarge = (megabytes: number) => `This file unpacks to more than the ${megabytes} MB allowed; export the scan with less in it.`;
export const elsewhere = "This file points to other files; export the scan with everything inside.";
export const tooLong = "Unpacking this file takes too long; export the scan again, as a plain GLB or PLY.";
export const noWorker = "This browser cannot unpack such a file; export the scan as a plain GLB, PLY or OBJ.";
export const unpacked = "unpacked.glb";
