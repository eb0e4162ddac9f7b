"""What the push and learned policies share: model files and their networks, and seeds and checkpoints of trainings.

`cards` reads and writes arrays with a JSON card, `layers` and `onnx` run networks, `seeds` keeps the random numbers of
training, testing and judging apart, and `checkpoints` carries a training out so that it can be stopped and resumed.
"""
