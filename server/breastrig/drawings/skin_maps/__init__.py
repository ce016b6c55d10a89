"""What the skin map (drawings/skin_maps/skin_map.py) knows before it sees a patient, as data with what reads it."""
