MODULE Names
    ! Names and errors: what RobotWare knows, never run.
    VAR num n;
    VAR errnum e:=-1;
    VAR datapos b;
    VAR dnum d;

    PROC main()
        %"proc"+NumToStr(n,0)%;
        CallByVar "proc",n;
        BookErrNo e;
        GetDataVal "n"\Block:=b,n;
        SetDataVal "n",n;
        IF Present(n) n:=1;
        again:
        n:=n+1;
        IF n<3 GOTO again;
        Load\Dynamic,"HOME:"\File:="a.mod";
        UnLoad "HOME:"\File:="a.mod";
        n:=1E9;
        d:=NumToDnum(n)*2;
        d:=-5;
        n:=5*-1;
    ENDPROC

    PROC proc1(\switch on|switch off,INOUT num a{*}\PERS tooldata t)
        MoveJ [[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t;
    BACKWARD
        n:=1;
    ERROR (ERR_PATH,ERR_DIVZERO)
        TRYNEXT;
    UNDO
        n:=2;
    ENDPROC
ENDMODULE
