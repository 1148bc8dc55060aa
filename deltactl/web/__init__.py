"""The page of the robot: what `deltactl web` serves to browsers.

In comes the daemon's socket, as to any other client, the folder of recordings and the robot
files; out go web pages, requests to the daemon, and reports. Nothing but the command line
imports this room. All JavaScript is that of NiceGUI, which brings its own and needs no network.
"""
