"""How much a scan may ask for.  Each is far above any real scan and far below what hurts."""

MEBIBYTE = 2**20
FILE_BYTES = 400 * MEBIBYTE
TRIANGLES = 5_000_000
VERTICES = 3 * TRIANGLES  # an STL repeats every corner
ZIP_ENTRIES = 20
ZIP_RATIO = 100  # bytes unpacked for each byte packed
ZIP_RATIO_FROM = 1 * MEBIBYTE  # a small file may be packed better than that without doing harm
IMAGE_PIXELS = 50_000_000
TEXTURE_SIDE = 4096  # pixels; larger textures are scaled down, many graphics cards take no more
GLTF_NODES = 10_000
