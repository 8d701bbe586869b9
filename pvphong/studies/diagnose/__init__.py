"""Diagnosis of meshes: faults that spoil the lighting.

Read `diagnosis` first: `diagnose`, and its result. `kinds` has the kinds of fault, in words, and when they spoil the
lighting; `remedies` has their code. `checks` looks at faces, edges, duplicates and the model matrix one by one,
`shells` at closed parts that are inside out, `orientation` at neighbours that face opposite ways.
"""
