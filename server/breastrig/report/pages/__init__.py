"""The pages of report.pdf, one a file, and the sheet that they are drawn on."""
