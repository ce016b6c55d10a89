"""Reports, measures, exports and contents of share links, made of folders of fits."""
