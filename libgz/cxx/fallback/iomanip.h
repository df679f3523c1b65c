/* The header of this name of C++ before its standard. License: Apache License 2.0. */
#include <iomanip>
using namespace std;
