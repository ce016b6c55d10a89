"""What BreastRig says, in other languages than English, from gettext catalogues (`de/LC_MESSAGES/breastrig.po`).

Sentences are raised and stored in English.  Where one is shown, `translation.said` looks for it among the catalogue's
msgids and puts its values into the translation.  Nothing is loaded for English.
"""
