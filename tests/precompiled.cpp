// Headers compiled beforehand (CMakeLists.txt) belong to a library, and a library has a source.
