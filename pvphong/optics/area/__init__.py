"""Integrals over what is seen of a light with a size, and of light all around, each as one formula.

Read `lobes` first: powers of a cosine over a region of the unit sphere as integrals along its boundary. `polygon` and
`disk` (a sphere is one too, to the eye) follow it along sides and rims; `harmonics` is a sky in bands. `sampling`
chooses points of lights for rays.
"""
