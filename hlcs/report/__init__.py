"""Reports: text, pages and pictures from plain records."""
