"""Diagnosis of meshes: faults that spoil the lighting.

Read `diagnosis` first: `diagnose` and its result. `kinds` describes the kinds of fault and when they spoil the
lighting; `remedies` has the code that repairs them. `checks` tests faces, edges, duplicates and the model matrix.
`shells` finds closed parts that are inside out, `orientation` neighbours that face opposite ways.
"""
