"""What a scan shows of landmarks without anybody having picked them."""
