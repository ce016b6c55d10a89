"""Limits of share links.  Each number has its reason.

What protects a passcode is the number of wrong ones that a link takes in all, from whatever addresses: a passcode that
was chosen at random is guessed with the chance WRONG_PASSCODES / (number of possible passcodes).  For six digits that
is 0.01 %, for the four digits that older versions allowed 1 %.  Whoever can guess at all already holds the link's 192
random bits; the delays only keep such a person from locking the link within seconds.
"""

PASSCODE_LENGTH = 6  # of new links; with four digits the same chance would leave one wrong passcode
WRONG_PASSCODES = 100  # honest people mistype far less often in 90 days; then the owner has to unlock the link
FREE_GUESSES = 3  # from one address before it has to wait: a person mistypes a few times
LONGEST_DELAY_S = 60.0  # between guesses from one address: an hour and a half to lock a link, a minute for a neighbour
ADDRESSES = 10_000  # whose guesses are remembered; 2 MB

VISIT_S = 12 * 3600  # a working day; the cookie itself ends with the browser
COOKIES = 20  # of one browser; all browsers keep 50 of a host, and the owner's own session is one of them

BIG_BYTES = 1_000_000  # smaller answers fit into the buffers of the network
BIG_ANSWERS = 32  # under way at once, each an open file and a thread
BIG_ANSWERS_EACH = 12  # of them of one share, and of one address: a tumour board looks at one result together
STILL_OPEN_S = 0.5  # after which a reader's right to a file is asked again: a third of a millisecond each time
BIG_RETRY_S = 3  # most readers need a second or two for the largest scan
