"""Textured pairs with exact truth: material maps, triangulations, atlases, speckle, damage.

Everything starts from material coordinates q (2 numbers, about mm on the reference
surface). A material map says where q lies before and after the deformation, the speckle is
a function of q alone, and each side is triangulated, cut into islands, painted, lit and
posed without knowing the other side.
"""
