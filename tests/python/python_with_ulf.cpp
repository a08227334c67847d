// Python with the module `ulf` inside: python_with_ulf ARGUMENTS of python3.
#include <Python.h>

extern "C" PyObject* PyInit_ulf();

int main(int argc, char** argv) {
  PyImport_AppendInittab("ulf", PyInit_ulf);
  return Py_BytesMain(argc, argv);
}
