"""The skin map's prior data (drawings/skin_maps/skin_map.py) with its readers."""
