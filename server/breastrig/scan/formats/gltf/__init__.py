"""glTF and GLB, whole or compressed, in the pose that the file gives them."""
