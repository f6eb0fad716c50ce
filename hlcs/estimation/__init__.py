"""From residuals to numbers: whitening, noise, least squares, multiple shooting, cross-validation, adequacy."""
