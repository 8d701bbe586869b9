"""What stands between vertices and lights, or the sky: arrays in, arrays out.

`casting.py` asks whether rays are blocked, by `embree.py` where embreex is installed (the extra `rays`) and by
`locator.py` where not; `occluders.py` holds what can block, `starts.py` says where a vertex's rays begin,
`sampling.py` how many are cast, and `tracing.py` puts them together for a scene.
"""
