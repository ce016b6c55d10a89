"""The numbers of ink detection, each with its reason. Lengths in m, densities in units of the natural logarithm.

They were set on four virtual patients whose colours are painted by formula, few and round on purpose, and none to a
single case. `breastrig evaluate` chooses their common factor anew for each patient, on the others; the numbers
themselves have seen all four. They are not validated on photographs of real skin. Ink of half the light adds a density
of 0.7.
"""

# Ridges
TEXEL = 0.6e-3  # m, of the pictures of the skin: a pen covers two or three; finer ones take longer and find no more
WIDTH = 1.0e-3  # standard deviation of the filter across a line: pens of 1 to 3 mm, blurred by the picture
WEAK = 0.10  # density above the skin's down to which a line is followed; the skin's own grain reaches 0.05
HUE_WORTH = 0.5  # of a line seen by its hue against one seen by its darkness, which compressed pictures keep sharper
ON_SKIN = 0.6  # share of the filter's weight that must lie on skin: ends of the scan look like lines
OFF_PIXEL = 0.6  # pixels from its pixel's middle; a half would lose ridges that lie between two pixels

# Chains of neighbouring points
REACH = 1.6e-3  # three pixels: what is seen obliquely has its points farther apart
TURN = 0.7  # cosine of 45 degrees from one point to the next
PIECE = 3.0e-3  # shorter chains are grain
PIECE_HEIGHT = 0.12  # mean density of a chain
BESIDE, BESIDE_SHARE = 1.2e-3, 0.7  # m, share of a piece that lies that near to a longer one: it is the same line

# What is ink: density added in red, green, blue (R, G, B) against the skin on both sides
COLOURED = 0.18  # R of violet, blue, green, which darken red; skin's own pigments darken it least, and B most
COLOURED_OVER = 0.04  # R over the least of G and B; moles, veins, scars and areolae have the least in R
PURE = 0.48  # G for each R, where B is less than G: blue cloth around the body has less, each ink on skin more
BLACK = 0.27  # R of black; loose hair and creases reach 0.25
BLACK_BLUE = 1.2  # B for each R of black; brown spots and faint brown lines have more
DARK, DARK_BLUE = 0.33, 1.45  # R from which thin black ink on brown skin may have so much; scars and veins stay below
# Where a scan has so much black ink that nothing else explains it, fainter lines are of that pen: on brown skin a worn
# or thin one adds hardly more than hair.  Chosen on painted brown women of the development half; scans without black
# ink never come here.
SURE_BLACK = 0.2  # m of black lines; hair, creases and tattoos leave none that pass for a plan
FAINT_BLACK, FAINT_BLUE = 0.17, 1.5  # for BLACK, and for both shares of B
FAINT_NARROWEST = 1.6e-3  # m; loose hair stays narrower
RED = 0.36  # of G and B for red ink; red scars reach 0.33
RED_OVER, RED_SHARE = 0.12, 1.2  # G over R, and G for each R
RED_BLUE = 1.2  # B for each G; blood and melanin have more
# On dark skin ink is lighter than skin in some channel: violet and blue in B, green in G, red in R.  No pigment is, and
# what is lighter as a whole (scars, gloss) changes no hue.  Chosen on painted women of the development half, five inks
# in six tones, texels of 0.6 and 1 mm.  Thin red ink on brown skin in coarse textures looks like vessels: not found.
HUE = 0.18  # R over the mean of G and B; under it for red
LIGHTER = 0.10  # by how much, in G or B, of violet, blue and green
# Violet and blue darken G and lighten B there, which hues do not add up: R over the lightest channel, and the hue then.
# Of violet on the darkest development woman 0.89 are found, of 0.50; 0.3 and 0.10 find 0.93 and more that is none.
OPPOSED, HUE_OF_OPPOSED = 0.36, 0.12
NO_DARKER_RED = 0.4  # R at most so much lighter for each G or B that is: green in shade is a little, gloss has 0.7
WIDEST_HUE = 4.6e-3  # m; JPEG keeps hues half as sharp
LIGHTER_RED, DARKER_GREEN = 0.1, 0.12  # R at most for each G of red ink, blood has twice as much; and its G
ECHO, ECHO_HUE = 7.0e-3, 0.9  # m from a line to the rim of the opposite hue that JPEG puts beside it; its share of hue
LENIENT = 0.65  # share of these densities that a piece needs to belong to a line that has them as a whole
WIDEST, WIDEST_BLACK = 3.8e-3, 3.4e-3  # m; shadows and creases are wider
NARROWEST_BLACK, CLEARLY_BLACK = 1.75e-3, 0.45  # m, unless R is that dark: loose hair is narrower and fainter
SKIN_SHARE = 0.45  # of the scan's usual B over R of bare skin, on both sides; cloth, table and hair have less

# Joining
GAP = 9.0e-3  # between dashes, where a pen left the skin, at crossings
HOLE = 20.0e-3  # where the scan has none of the skin between
END = 5.0e-3  # at whose middle the direction of an end is taken
STRAIGHT = 0.8  # cosine of 37 degrees between an end and the way to the next
CROSSING, STRAIGHT_AT_CROSSING = 2.5e-3, 0.6  # nearer ends are at a crossing, where the filter rounds corners
SAME_INK = 0.35  # how far the added densities of two pieces may differ, as share of the larger
DIFFERENT_INK = 6.0e-3  # m of gap that a full difference counts as

# Lines
LENGTH = 8.0e-3  # shorter strokes are moles and grain
SPACING = 1.0e-3  # between points of a line
SMOOTH = 1.5e-3  # standard deviation along a line

# Kinds of strokes
FINE_ENOUGH = 1.5e-3  # m between texels or coloured vertices; with coarser ones a pen's line falls between
CURLY = 110.0  # rad for each m of a stroke: circles of 9 mm; letters, curls and arrow heads turn more, lines less
STRAIGHT_STROKE = 40.0  # rad for each m; crosses and the shafts of arrows turn less
DETAIL, DETAIL_REACH = 4.0e-3, 4.0e-3  # shorter strokes than LENGTH count when they touch a longer one of this ink
WORD = 10.0e-3  # between strokes of one word
WORD_STROKE = 25.0e-3  # strokes of letters without curls are no longer
TATTOO = 60.0e-3  # of curly black strokes at one place: more than a surgeon's letters or numbers
GREY = 0.35  # by how much red, green and blue of black may differ, as share of the largest
# A scan has ink if a line of a plan is left with all densities so much larger: of pens 200 mm or more are, of veins on
# the darkest skin, hair and tattoos none. Seen on painted women of both halves; 1.2 and 1.6 say the same of each.
SURE = 1.45
PLAN = 30.0e-3  # a scan without a line of this length has no plan on it: marks alone are tattoos and stains
CROSS = 25.0e-3  # arms of crosses are no longer
CROSS_MIDDLE = 4.0e-3  # from the middle of one arm to the other
CROSS_ANGLE = 0.7  # cosine of 45 degrees
ARROW, ARROW_HEAD, ARROW_TIP = 60.0e-3, 30.0e-3, 4.0e-3  # longest shaft, longest head, between the two
DASHES, DASH, DASH_GAP = 4, 25.0e-3, 1.5e-3  # at least so many, no longer on average, with gaps no shorter
