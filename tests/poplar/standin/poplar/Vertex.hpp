// A stand-in for the header of the same name in the Poplar SDK, written from public documents: as much of it as the library's codelets
// use. With it, codelets compile and run on a host. It is never installed, and a test that passes with it proves nothing about an IPU.
#pragma once
#ifndef __POPC__
#    define __POPC__ 1 // this is codelet code; `__IPU__` stays undefined
#endif

namespace poplar {

/// A piece of tile memory, in an Input, InOut or Output. A Vector of these edges is a list. Indices are not checked.
template <class T>
class Vector {
public:
    T& operator[](unsigned i) { return data_[i]; }
    T* begin() { return data_; }
    T* end() { return data_ + size_; }
    unsigned size() const { return size_; }

private:
    T* data_; // a loader sets these two
    unsigned size_;
};

/// An edge that a vertex reads.
template <class T>
class Input;
template <class T>
class Input<Vector<T>> : public Vector<T const> {};

/// An edge that a vertex reads and writes.
template <class T>
class InOut;
template <class T>
class InOut<Vector<T>> : public Vector<T> {};

/// An edge that a vertex writes; its words before that are undefined.
template <class T>
class Output {
public:
    T& operator=(T const& value) { return *data_ = value; } // NOLINT: the element is assigned, not the edge

private:
    T* data_;
};
template <class T>
class Output<Vector<T>> : public Vector<T> {};

/// A codelet for one worker: it defines `bool compute()`.
class Vertex {};

/// A codelet that all workers of a tile execute at once: it defines `bool compute(unsigned worker)`.
class MultiVertex {};

} // namespace poplar
