"""From a tree of components to one flat system of differential-algebraic equations."""
