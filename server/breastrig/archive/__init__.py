"""A fit for a hospital's archive and its viewers: DICOM objects of one study."""
