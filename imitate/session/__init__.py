"""The workflow: observe, segment, review, learn, reproduce, replay."""
