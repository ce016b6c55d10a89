"""How much a scan may ask for.  Each is far above any real scan and far below what hurts."""

MEBIBYTE = 2**20
FILE_BYTES = 400 * MEBIBYTE
TRIANGLES = 2_000_000  # an edge of 1 mm on a torso; reading one takes 20 s, of which most is finding how she lies
VERTICES = 3 * TRIANGLES  # an STL repeats every corner
POINTS = 5_000_000  # of a cloud; a depth camera that goes around a torso sees some 500,000
PCD_HEADER_BYTES = 10_000  # eleven lines
PCD_FIELDS = 100  # columns of a point, and numbers in a column; features of 33 numbers are in use
ZIP_ENTRIES = 2_000  # apps pack a picture, a depth map and a description of each of some hundred frames with the scan
ZIP_LIST_BYTES = 1 * MEBIBYTE  # the list of entries at a zip's end: that is 500 bytes for each
ZIP_RATIO = 100  # bytes unpacked for each byte packed
ZIP_RATIO_FROM = 1 * MEBIBYTE  # a small file may be packed better than that without doing harm
IMAGE_PIXELS = 50_000_000
JPEG_PASSES = 100  # a progressive JPEG has about ten; each goes over the whole picture when it is decoded
TEXTURE_SIDE = 4096  # pixels; larger textures are scaled down, many graphics cards take no more
MATERIALS = 256  # of an OBJ, each becomes a mesh of its own that looks at all vertices; scanner apps write one to 60
MATERIAL_FILE_BYTES = 1 * MEBIBYTE  # 256 materials of ten lines have some 100 kB
STL_SOLIDS = 256  # each becomes a mesh of its own; a scan is one
PLY_HEADER_BYTES = 100_000  # a header that is longer than this is none
USD_PRIMS = 10_000  # parts of a scene; object scans have some ten
USD_MEMORY = 3 * 1024 * MEBIBYTE  # of the process that reads one: the library itself takes one, a scan half of that
USD_SECONDS = 120  # of work; a scan of a million triangles takes five
GLTF_JSON_BYTES = 16 * MEBIBYTE  # 2 s of work; numbers and pictures lie in the binary part
GLTF_ENTRIES = 20_000  # in any one list of the document; our own fitted.glb has some 600 accessors
GLTF_NODES = 10_000  # 0.1 s of work
GLTF_DEPTH = 100  # nodes above one another; skeletons with fingers have some 25
GLTF_PRIMITIVES = 2_000  # drawn ones, each as often as nodes draw it: 0.2 s of work; scanner apps write up to some 100
