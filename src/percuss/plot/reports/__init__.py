"""Reports as files: what stands on their pages, written as HTML or as PDF."""
