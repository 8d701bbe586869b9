"""What in a mesh will not light as it should.

Read `diagnosis` first: the kinds of fault, `diagnose`, and its result. `checks` looks at faces, edges, duplicates and
the model matrix one by one, `shells` at closed parts that are inside out.
"""
