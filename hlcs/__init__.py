"""The laboratory: place armour units, measure layers, compare with data, find the missing effect."""
