"""Where files can be kept: in the data folder, or in a store such as S3."""
